#include "server/queries/sampled_power.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

#include "lights/sampling/sobol.h"
#include "server/estimate/block_stream.h"
#include "server/estimate/pilots.h"
#include "server/estimate/sample_sum.h"
#include "server/runtime/parallel.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

// A ray takes about a tenth of a microsecond, so the stop token is polled every few tens of
// microseconds.
constexpr std::uint32_t kEmittedBetweenPolls = 256;
// A chunk of lights takes about a millisecond.
constexpr std::uint64_t kEmittedPerChunk = 8192;

/// The estimate of the light's power from one ray [lm].
Rgb power_of(const EmissionSample& s) {
  if (s.reason != NoLight::kNone) return {};
  Rgb power = s.value;
  if (s.normal != Vec3{}) power = power * std::fabs(dot(s.normal, s.direction));
  // A density of 0 means that the choice is certain.
  if (s.pdf_position.per_m2 > 0) power = power / s.pdf_position.per_m2;
  if (s.pdf_direction.per_sr > 0) power = power / s.pdf_direction.per_sr;
  return power;
}

struct LightRun {
  BlockStream<4> stream{0};        // R, G, B and luminance [lm]
  std::vector<double> block_lm{};  // of each block
  double sum_of_squares = 0, largest = 0;
};

class PowerEstimator {
 public:
  PowerEstimator(const Scene& scene, const SampledPowerSettings& settings,
                 const std::stop_token& stop)
      : scene_(scene),
        settings_(settings),
        confidence_(settings.target ? settings.target->confidence : kConfidence),
        stop_(stop) {}

  /// Sets `block_lm` to the means of the blocks [lm].
  SampledPower light(std::uint32_t light, std::vector<double>& block_lm) {
    std::uint32_t each = settings_.samples_per_block;
    if (settings_.target) {
      each = needed_samples_per_block(*settings_.target, settings_.block_count,
                                      [&](const Blocks& these) -> std::optional<PilotEstimate> {
                                        const LightRun pilot = run(light, these);
                                        if (stopped_) return std::nullopt;
                                        const SampledPower e =
                                            estimate(pilot, these, settings_.block_count);
                                        return PilotEstimate{luminance(e.lumens), e.interval_lm};
                                      });
    }
    const Blocks these{0, settings_.block_count, each};
    LightRun answer = run(light, these);
    if (stopped_) return {};
    block_lm = std::move(answer.block_lm);
    return estimate(answer, these, settings_.block_count);
  }

  /// The interval of a mean of independent blocks.
  ConfidenceInterval interval(const EstimateMoments& moments, std::uint64_t blocks,
                              std::uint64_t samples) const {
    return IntervalRule(confidence_, blocks, samples).interval(moments);
  }

  bool stopped() const { return stopped_; }
  std::uint64_t samples() const { return samples_; }

 private:
  LightRun run(std::uint32_t light, const Blocks& these) {
    const LightAtTime l(scene_.lights()[light], -std::numeric_limits<double>::infinity());
    LightRun result;
    for (std::uint64_t b = these.first; b < these.first + these.count; ++b) {
      const SobolSequence points(settings_.seed, scene_.lights()[light].id, b);
      const std::optional<Rgb> mean = block(*l, points, these.samples, result);
      if (!mean) return result;
      result.stream.add({mean->r, mean->g, mean->b, luminance(*mean)});
      result.block_lm.push_back(luminance(*mean));
    }
    samples_ += these.count * these.samples;
    return result;
  }

  /// The mean power of `n` rays [lm]; nothing if it was stopped.
  std::optional<Rgb> block(const Light& light, const SobolSequence& points, std::uint32_t n,
                           LightRun& run) {
    const SceneSphere sphere = scene_.sphere();
    SampleSum sum;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (i % kEmittedBetweenPolls == 0 && stop_.stop_requested()) {
        stopped_ = true;
        return std::nullopt;
      }
      const Vec2f position = points.pair(i, 0), direction = points.pair(i, 1);
      const Rgb power =
          power_of(light.sample_le({position.x, position.y}, {direction.x, direction.y}, sphere));
      sum.add(power);
      const double lumens = luminance(power);
      run.sum_of_squares += lumens * lumens;
      run.largest = std::max(run.largest, lumens);
    }
    return sum.value() / n;
  }

  SampledPower estimate(const LightRun& run, const Blocks& these, std::uint64_t blocks) const {
    const auto count = static_cast<double>(these.count);
    const auto total = run.stream.total();
    SampledPower e;
    e.lumens = {total[0].sum / count, total[1].sum / count, total[2].sum / count};
    e.standard_error_lm = standard_error(total[3], count);
    e.samples = these.count * these.samples;
    e.interval_lm =
        interval({total[3].sum / count, e.standard_error_lm, run.sum_of_squares, run.largest},
                 blocks, e.samples);
    return e;
  }

  const Scene& scene_;
  const SampledPowerSettings& settings_;
  const double confidence_;
  const std::stop_token& stop_;
  std::atomic<bool> stopped_ = false;
  std::atomic<std::uint64_t> samples_ = 0;
};

}  // namespace

SampledPowers sample_powers(const Scene& scene, std::span<const std::uint32_t> lights,
                            const SampledPowerSettings& settings, std::stop_token stop) {
  SampledPowers result;
  result.lights.resize(lights.size());
  std::vector<std::vector<double>> block_lm(lights.size());
  PowerEstimator estimator(scene, settings, stop);
  const std::uint64_t each = std::uint64_t{settings.block_count} * settings.samples_per_block;
  const std::size_t grain =
      settings.target ? 1 : std::max<std::uint64_t>(1, kEmittedPerChunk / each);
  parallel_chunks(lights.size(), grain, stop, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !estimator.stopped(); ++i)
      result.lights[i] = estimator.light(lights[i], block_lm[i]);
  });
  result.stopped = estimator.stopped() || stop.stop_requested();
  result.work.samples = estimator.samples();
  if (result.stopped) return result;

  // Lights are independent.  So the sums over lights for each block number are independent too.
  BlockStream<1> stream(0);
  for (std::uint32_t b = 0; b < settings.block_count; ++b) {
    CompensatedSum sum;
    for (const std::vector<double>& of_light : block_lm) sum.add(of_light[b]);
    stream.add({sum.value()});
  }
  SampleSum lumens;
  for (const SampledPower& light : result.lights) {
    lumens.add(light.lumens);
    result.total.samples += light.samples;
  }
  const double count = settings.block_count;
  const BlockStatistics total = stream.total()[0];
  const double mean = total.sum / count;
  result.total.lumens = lumens.value();
  result.total.standard_error_lm = standard_error(total, count);
  // The rays of all lights together are not rare events, so they count as equal samples.
  const std::uint64_t samples = std::max<std::uint64_t>(1, result.total.samples);
  result.total.interval_lm = estimator.interval(
      {mean, result.total.standard_error_lm, mean * mean * static_cast<double>(samples), mean},
      settings.block_count, samples);
  return result;
}

}  // namespace lucerna
