#include "server/render.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <array>
#include <atomic>
#include <mutex>
#include <vector>

#include "server/block_stream.h"
#include "server/denormals.h"
#include "server/path.h"

namespace lucerna {
namespace {

// A path is a few rays: between two looks at the stop token lie a few hundred.
constexpr std::uint32_t kSamplesBetweenPolls = 64;

// Pixels of one task: enough to pay for it, few enough to share the work out evenly.
constexpr std::size_t kTaskWidth = 16, kTaskHeight = 4;

class TileJob {
 public:
  TileJob(const Scene& scene, const TileSettings& settings, const std::stop_token& stop,
          TileResult& result)
      : scene_(scene),
        settings_(settings),
        tracer_(scene, settings.bounces),
        stop_(stop),
        result_(result) {}

  void pixels(const tbb::blocked_range2d<int>& range) {
    const DenormalsAreZero denormals;
    WorkCounts work;
    const PixelRect& rect = settings_.rect;
    const auto width = static_cast<std::size_t>(rect.x1 - rect.x0);
    for (int y = range.rows().begin(); y < range.rows().end() && !stopped_; ++y)
      for (int x = range.cols().begin(); x < range.cols().end() && !stopped_; ++x) {
        const std::size_t at = 3 * (static_cast<std::size_t>(y - rect.y0) * width +
                                    static_cast<std::size_t>(x - rect.x0));
        const auto total = pixel(x, y, work);
        std::ranges::copy(total, result_.channels.begin() + static_cast<std::ptrdiff_t>(at));
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
    Rgb<double> sum;
    const std::uint32_t n = settings_.samples_per_block;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (i % kSamplesBetweenPolls == 0 && stop_.stop_requested()) {
        stopped_ = true;
        return {};
      }
      const PathSample sample{sequence, i};
      const Vec2<float> film = sample.pair(PathSample::kFilm);
      const Ray ray =
          scene_.camera().ray(static_cast<float>(x) + film.x, static_cast<float>(y) + film.y);
      sum += Rgb<double>(tracer_.radiance(ray, sample, work));
    }
    work.samples += n;
    return sum * (scene_.camera().film_scale() / n);
  }

  const Scene& scene_;
  const TileSettings& settings_;
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
  return *this;
}

TileResult render_tile(const Scene& scene, const TileSettings& settings, std::stop_token stop) {
  TileResult result;
  const PixelRect& r = settings.rect;
  result.channels.resize(3 * static_cast<std::size_t>(r.x1 - r.x0) *
                         static_cast<std::size_t>(r.y1 - r.y0));
  TileJob job(scene, settings, stop, result);
  // Isolated: a thread that waits here must not take up another request's work, which would hold
  // this one's answer back.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(tbb::blocked_range2d<int>(r.y0, r.y1, kTaskHeight, r.x0, r.x1, kTaskWidth),
                      [&](const tbb::blocked_range2d<int>& range) { job.pixels(range); });
  });
  result.stopped = job.stopped();
  return result;
}

}  // namespace lucerna
