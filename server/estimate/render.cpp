#include "server/estimate/render.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "server/estimate/block_stream.h"
#include "server/estimate/path.h"
#include "server/estimate/pilots.h"
#include "server/estimate/sample_sum.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

// A path takes a few rays, so a few hundred rays lie between two polls of the stop token.
constexpr std::uint32_t kSamplesBetweenPolls = 64;
/// The distance of neighbour rays [pixels]: that of pbrt-v4 for 64 samples and more.  Samples
/// average over the rest of the pixel.
constexpr float kFootprint = 0.125F;

// Samples of one chunk of pixels: 0.1 to 10 ms.
constexpr std::uint64_t kSamplesPerChunk = 256;

class TileEstimator {
 public:
  TileEstimator(const Scene& scene, const TileSettings& settings, const std::stop_token& stop,
                TileResult& result)
      : scene_(scene),
        settings_(settings),
        shutter_(settings.shutter.value_or(
            Shutter{scene.report().hints.shutter_open_s, scene.report().hints.shutter_close_s})),
        tracer_(scene, settings.bounces, settings.methods,
                settings.one_sequence ? DirectLight::kCandidatesOfOneSequence
                                      : DirectLight::kCandidates),
        stop_(stop),
        result_(result) {}

  std::size_t width() const {
    return static_cast<std::size_t>(settings_.rect.x1 - settings_.rect.x0);
  }
  std::size_t height() const {
    return static_cast<std::size_t>(settings_.rect.y1 - settings_.rect.y0);
  }

  // Renders pixels [begin, end) of the tile, in row order.
  void pixels(std::size_t begin, std::size_t end, WorkCounts& work) {
    for (std::size_t i = begin; i < end && !stopped_; ++i) {
      // Positions on the film, so a pixel has the same bits in a crop as in the whole picture.
      const FilmCrop& crop = scene_.camera().crop();
      const int x = crop.x0 + settings_.rect.x0 + static_cast<int>(i % width()),
                y = crop.y0 + settings_.rect.y0 + static_cast<int>(i / width());
      if (settings_.target) {
        pixel_within_target(x, y, i, work);
      } else {
        pixel_by_count(x, y, i, work);
      }
    }
  }

  bool stopped() const { return stopped_; }

 private:
  /// With this many samples, the mean is so close to normal that 95% intervals hold in 94% of
  /// cases: 25 times the squared skewness of the samples.  [Cochran77, 2.15]
  static double least_samples(const EstimateMoments& m) {
    // A deviation below the rounding error of the rays has no meaningful skewness.
    return m.deviation > 3e-5 * m.mean ? 25 * m.skewness * m.skewness : 0;
  }

  void put(std::size_t i, const ChannelStatistics<3>& channels) {
    std::copy_n(channels.begin(), 3, result_.channels.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }

  void pixel_by_count(int x, int y, std::size_t i, WorkCounts& work) {
    const Blocks these{settings_.first_block, static_cast<std::uint32_t>(settings_.block_count),
                       settings_.samples_per_block};
    put(i, pixel(x, y, these, settings_.intervals ? &result_.moments[i] : nullptr, work));
  }

  /// Statistics of R, G and B and, unless null, of the luminance.
  ChannelStatistics<3> pixel(int x, int y, const Blocks& these, LuminanceMoments* moments,
                             WorkCounts& work) {
    const auto item =
        static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(scene_.camera().film_width()) +
        static_cast<std::uint64_t>(x);
    BlockStream<3> channels(these.first);
    BlockTotal<LuminanceMoments> luminances(these.first);
    for (std::uint64_t b = these.first; b < these.first + these.count; ++b) {
      const bool one = settings_.one_sequence;
      const SampleSequence sequence(settings_.methods.sampler, settings_.seed, item, one ? 0 : b);
      const PathSample first{sequence, one ? static_cast<std::uint32_t>(b * these.samples) : 0};
      BlockMoments of_block(scene_.camera().may_be_negative());
      const Rgb mean =
          block(x, y, first, these.samples, moments != nullptr ? &of_block : nullptr, work);
      if (stopped_) return {};
      channels.add({mean.r, mean.g, mean.b});
      if (moments != nullptr) luminances.add(of_block.result(luminance(mean)));
    }
    if (moments != nullptr) *moments = luminances.total();
    return channels.total();
  }

  void pixel_within_target(int x, int y, std::size_t i, WorkCounts& work) {
    const std::uint64_t blocks = settings_.block_count;
    const auto interval = [&](const EstimateMoments& m, std::uint64_t samples) {
      return IntervalRule(settings_.target->confidence, blocks, samples).interval(m);
    };
    const auto needed =
        needed_samples(*settings_.target, [&](const Blocks& these) -> std::optional<PilotEstimate> {
          LuminanceMoments moments;
          pixel(x, y, these, &moments, work);
          if (stopped_) return std::nullopt;
          const std::uint64_t samples = std::uint64_t{these.count} * these.samples;
          const EstimateMoments m = estimate_moments(moments, these.count, samples);
          return PilotEstimate{m.mean, interval(m, samples), least_samples(m)};
        });
    if (!needed) return;
    // Sample counts of a tile are powers of two.
    const std::uint64_t samples =
        std::min(std::bit_ceil(static_cast<std::uint64_t>(std::ceil(*needed))),
                 std::bit_floor(settings_.target->max_samples));
    const Blocks these{0, blocks, static_cast<std::uint32_t>(samples / blocks)};
    LuminanceMoments moments;
    const ChannelStatistics<3> channels = pixel(x, y, these, &moments, work);
    if (stopped_) return;
    put(i, channels);
    result_.samples[i] = static_cast<std::uint32_t>(samples);
    result_.intervals[i] = interval(estimate_moments(moments, these.count, samples), samples);
  }

  /// The mean of a block of n samples.
  Rgb block(int x, int y, const PathSample& first, std::uint32_t n, BlockMoments* moments,
            WorkCounts& work) {
    const Camera& camera = scene_.camera();
    const PixelFilter* const filter = camera.filter();
    const bool has_lens = camera.has_lens();
    const double scale = camera.film_scale();
    SampleSum sum;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (i % kSamplesBetweenPolls == 0 && stop_.stop_requested()) {
        stopped_ = true;
        return {};
      }
      const PathSample sample{first.sequence, first.index + i};
      PixelFilter::Sample film{sample.pair(PathSample::kFilm), 1};
      if (filter != nullptr) film = filter->sample(film.position_px);
      const auto ray_at = [&](float dx, float dy) {
        return camera.ray(static_cast<float>(x) + film.position_px.x + dx,
                          static_cast<float>(y) + film.position_px.y + dy, time(sample),
                          has_lens ? sample.pair(PathSample::kLens) : Vec2f{0.5F, 0.5F});
      };
      std::optional<NeighbourRays> neighbours;
      if (scene_.geometry().textures().uses_footprints())
        neighbours = {ray_at(kFootprint, 0), ray_at(0, kFootprint)};
      LightEstimate e =
          tracer_.radiance(ray_at(0, 0), sample, work, neighbours ? &*neighbours : nullptr);
      if (film.weight != 1) e = {e.value * film.weight, e.unshadowed * std::fabs(film.weight)};
      sum.add(e.value);
      if (moments == nullptr) continue;
      moments->add(luminance(e.value) * scale, luminance(e.unshadowed) * scale);
    }
    work.samples += n;
    // Squared differences must fit too, so larger values count as the largest float.
    const auto held = [](double v) {
      constexpr double kLargest = std::numeric_limits<float>::max();
      return v > kLargest ? kLargest : v < -kLargest ? -kLargest : v;
    };
    const Rgb mean = sum.value() * (scale / n);
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
  std::atomic<bool> stopped_ = false;
};

}  // namespace

TileResult render_tile(const Scene& scene, const TileSettings& settings, std::stop_token stop) {
  TileResult result;
  TileEstimator estimator(scene, settings, stop, result);
  const std::size_t pixels = estimator.width() * estimator.height();
  result.channels.resize(3 * pixels);
  if (settings.target) {
    result.samples.resize(pixels);
    result.intervals.resize(pixels);
  } else if (settings.intervals) {
    result.moments.resize(pixels);
  }
  const std::uint64_t samples_per_pixel = settings.block_count * settings.samples_per_block;
  const std::size_t grain =
      settings.target ? 1 : std::max<std::uint64_t>(1, kSamplesPerChunk / samples_per_pixel);
  result.work =
      parallel_work(pixels, grain, stop, [&](std::size_t begin, std::size_t end, WorkCounts& work) {
        estimator.pixels(begin, end, work);
      });
  result.stopped = estimator.stopped() || stop.stop_requested();
  return result;
}

}  // namespace lucerna
