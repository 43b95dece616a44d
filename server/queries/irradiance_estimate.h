// Sums over the samples of one irradiance estimate.
#pragma once

#include <absl/functional/function_ref.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/common/confidence.h"
#include "server/estimate/block_stream.h"
#include "server/estimate/direct_light.h"
#include "server/estimate/sample_sum.h"
#include "server/estimate/spectral_values.h"
#include "server/queries/receiver_irradiance.h"

namespace lucerna {

/// One estimated number: the total, or the share of one light.
struct Estimate {
  bool may_be_hidden = false;     // EstimateMoments::may_be_hidden
  BlockStream<4> blocks{0};       // R, G, B and luminance [lx]
  SampleSum block_sum{};          // of the samples of the current block
  double sum_of_squares = 0;      // of samples' illuminances
  double largest_unshadowed = 0;  // largest illuminance of a sample without shadows [lx]
  bool partly_hidden = false;     // some sample was shadowed
  std::uint64_t samples = 0;
  std::uint64_t lit = 0;  // samples with light, shadowed or not

  /// Adds all light of one sample [lx].  Samples without light need no call.
  void add(const LightEstimate& e) {
    block_sum.add(e.value);
    const double lux = luminance(e.value);
    sum_of_squares += lux * lux;
    const double unshadowed = luminance(e.unshadowed);
    largest_unshadowed = std::max(largest_unshadowed, unshadowed);
    partly_hidden |= lux < unshadowed;
    lit += unshadowed > 0 ? 1 : 0;
  }
  /// Adds light to the mean of the current block [lx].
  void add_to_block(const Rgb& lx, std::uint32_t samples) {
    block_sum.add(lx * static_cast<double>(samples));
  }
  void end_block(std::uint32_t block_samples) {
    samples += block_samples;
    const Rgb v = block_sum.value() / block_samples;
    blocks.add({v.r, v.g, v.b, luminance(v)});
    block_sum = {};
  }
  /// Upper bounds of the direct light of the samples.  `missed`: only of lights of which no sample
  /// found light.
  using Most = absl::FunctionRef<MostIrradiance(bool missed)>;
  /// `exact`: additional light that did not need sampling [lx].
  IrradianceEstimate result(const Rgb& exact, double block_count, const IntervalRule& rule,
                            Most most) const;

 private:
  /// The interval of the sampled light [lx].
  ConfidenceInterval interval(double mean, double standard_error, const IntervalRule& rule,
                              Most most) const;
};

/// Sets an answer that did not need samples [lx].
inline void set_exact(Rgb exact, IrradianceEstimate& e) {
  e.irradiance_lx = exact;
  e.exact = true;
  const double exact_lx = luminance(exact);
  e.illuminance_lx = {exact_lx, exact_lx};
}

// If few samples found light, they say little about what other samples may find.  A light of which
// no sample found any adds its bound.
inline ConfidenceInterval Estimate::interval(double mean, double standard_error,
                                             const IntervalRule& rule, Most most) const {
  constexpr std::uint64_t kFew = 8;
  EstimateMoments moments{mean,          standard_error, sum_of_squares, largest_unshadowed,
                          partly_hidden, may_be_hidden};
  ConfidenceInterval result = rule.interval(moments);
  const bool few = lit < kFew && 4 * lit < samples;
  const MostIrradiance bounds = most(!few);
  if (!(bounds.lx > 0)) return result;
  if (!few) moments = {};
  moments.largest = std::max(moments.largest, bounds.sample_lx);
  const double wider = std::isfinite(bounds.sample_lx) ? rule.interval(moments).upper : bounds.lx;
  const double most_lx = std::min(bounds.lx, wider);
  result.upper = few ? std::max(result.upper, most_lx) : result.upper + most_lx;
  return result;
}

inline IrradianceEstimate Estimate::result(const Rgb& exact, double block_count,
                                           const IntervalRule& rule, Most most) const {
  IrradianceEstimate e;
  e.irradiance_lx = exact;
  const double exact_lx = luminance(exact);
  const auto total = blocks.total();
  const auto mean = [&](int i) { return total[i].sum / block_count; };
  e.irradiance_lx += {mean(0), mean(1), mean(2)};
  e.illuminance_error_lx = standard_error(total[3], block_count);
  const ConfidenceInterval sampled_lx = interval(mean(3), e.illuminance_error_lx, rule, most);
  e.illuminance_lx = {exact_lx + sampled_lx.lower, exact_lx + sampled_lx.upper};
  if (!(mean(3) > 0) && sampled_lx.upper > 0) e.zero_bound_lx = e.illuminance_lx.upper;
  return e;
}

/// Light of samples, grouped by the spectrum of its lights [lx].  Not used without wavelengths.
class BySpectrum {
 public:
  /// Group 0: lights with RGB values.  Group 1 + k: lights with spectrum k of the scene.
  explicit BySpectrum(std::size_t groups) : sums_(groups) {}

  bool wanted() const { return !sums_.empty(); }
  void add(std::size_t group, const Rgb& lx) {
    if (lx.is_black()) return;
    if (sums_[group].value().is_black()) lit_.push_back(group);
    sums_[group].add(lx);
  }
  /// Adds the sums times `scale` at each wavelength to `at`, and clears the sums.
  void put(SpectralValues& spectral, double scale, std::span<double> at) {
    for (const std::size_t g : lit_) {
      std::optional<std::uint32_t> spectrum;
      if (g > 0) spectrum = static_cast<std::uint32_t>(g - 1);
      spectral.add(spectrum, sums_[g].value() * scale, at);
      sums_[g] = {};
    }
    lit_.clear();
  }

 private:
  std::vector<SampleSum> sums_;
  std::vector<std::size_t> lit_;  // groups that are not 0
};

}  // namespace lucerna
