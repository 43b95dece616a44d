#include "server/render.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <vector>

#include "server/block_stream.h"
#include "server/denormals.h"
#include "server/parallel.h"
#include "server/path.h"
#include "server/sample_sum.h"

namespace lucerna {
namespace {

// A path is a few rays: between two looks at the stop token lie a few hundred.
constexpr std::uint32_t kSamplesBetweenPolls = 64;

// Samples of one chunk of pixels: about a millisecond.
constexpr std::uint64_t kSamplesPerChunk = 1024;

class TileJob {
 public:
  TileJob(const Scene& scene, const TileSettings& settings, const std::stop_token& stop,
          TileResult& result)
      : scene_(scene),
        settings_(settings),
        shutter_(settings.shutter.value_or(
            Shutter{scene.hints().shutter_open_s, scene.hints().shutter_close_s})),
        tracer_(scene, settings.bounces, settings.methods),
        stop_(stop),
        result_(result) {}

  std::size_t width() const {
    return static_cast<std::size_t>(settings_.rect.x1 - settings_.rect.x0);
  }
  std::size_t height() const {
    return static_cast<std::size_t>(settings_.rect.y1 - settings_.rect.y0);
  }

  // Pixels of the tile in row order.
  void pixels(std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    WorkCounts work;
    for (std::size_t i = begin; i < end && !stopped_; ++i) {
      const auto total = pixel(settings_.rect.x0 + static_cast<int>(i % width()),
                               settings_.rect.y0 + static_cast<int>(i / width()), work);
      std::ranges::copy(total, result_.channels.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
    const std::lock_guard lock(mutex_);
    result_.work += work;
  }

  bool stopped() const { return stopped_; }

 private:
  std::array<BlockStatistics, 3> pixel(int x, int y, WorkCounts& work) {
    const auto item =
        static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene_.camera().width()) +
        static_cast<std::uint64_t>(x);
    BlockStream<3> stream(settings_.first_block);
    const std::uint64_t end = settings_.first_block + settings_.block_count;
    for (std::uint64_t b = settings_.first_block; b < end; ++b) {
      const Rgb<double> mean = block(x, y, SobolSequence(settings_.seed, item, b), work);
      if (stopped_) return {};
      stream.add({mean.r, mean.g, mean.b});
    }
    return stream.total();
  }

  Rgb<double> block(int x, int y, const SobolSequence& sequence, WorkCounts& work) {
    SampleSum sum;
    const std::uint32_t n = settings_.samples_per_block;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (i % kSamplesBetweenPolls == 0 && stop_.stop_requested()) {
        stopped_ = true;
        return {};
      }
      const PathSample sample{sequence, i};
      const Vec2<float> film = sample.pair(PathSample::kFilm);
      const Ray ray = scene_.camera().ray(static_cast<float>(x) + film.x,
                                          static_cast<float>(y) + film.y, time(sample));
      sum.add(tracer_.radiance(ray, sample, work));
    }
    work.samples += n;
    // Squares of differences are summed too: what no float holds counts as the largest.
    const auto held = [](double v) {
      constexpr double kLargest = std::numeric_limits<float>::max();
      return v > kLargest ? kLargest : v;
    };
    const Rgb<double> mean = sum.value() * (scene_.camera().film_scale() / n);
    return {held(mean.r), held(mean.g), held(mean.b)};
  }

  double time(const PathSample& sample) const {
    if (settings_.time_s) return *settings_.time_s;
    if (!scene_.moves()) return 0;
    const double u = sample.pair(PathSample::kTime).x;
    return shutter_.open_s * (1 - u) + shutter_.close_s * u;
  }

  const Scene& scene_;
  const TileSettings& settings_;
  const Shutter shutter_;
  PathTracer tracer_;
  const std::stop_token& stop_;
  TileResult& result_;
  std::mutex mutex_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace

WorkCounts& WorkCounts::operator+=(const WorkCounts& w) {
  samples += w.samples;
  camera_rays += w.camera_rays;
  indirect_rays += w.indirect_rays;
  shadow_rays += w.shadow_rays;
  map_lookups += w.map_lookups;
  map_compared += w.map_compared;
  map_disagreed += w.map_disagreed;
  return *this;
}

TileResult render_tile(const Scene& scene, const TileSettings& settings, std::stop_token stop) {
  TileResult result;
  TileJob job(scene, settings, stop, result);
  const std::size_t pixels = job.width() * job.height();
  result.channels.resize(3 * pixels);
  const std::uint64_t samples_per_pixel = settings.block_count * settings.samples_per_block;
  const std::size_t grain = std::max<std::uint64_t>(1, kSamplesPerChunk / samples_per_pixel);
  parallel_chunks(pixels, grain, stop,
                  [&](std::size_t begin, std::size_t end) { job.pixels(begin, end); });
  result.stopped = job.stopped() || stop.stop_requested();
  return result;
}

}  // namespace lucerna
