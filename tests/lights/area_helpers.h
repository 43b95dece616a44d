// Helpers for tests of shapes and area lights: illuminance by sampling, and a test of uniformity.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "lights/models/area_light.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {

/// A receiver that always samples points uniformly by area.
inline Receiver by_area(const Vec3& position) {
  Receiver receiver(position);
  receiver.area_sampling = AreaSampling::kLowDistortion;
  return receiver;
}

/// A mean with its standard error.
struct Estimate {
  double mean = 0, standard_error = 0;
};

/// Unshadowed illuminance of the red channel at a surface with normal `n`, from `samples`
/// independent samples of the light.
template <typename Light>
Estimate illuminance(const Light& light, const Receiver& receiver, const Vec3& n,
                     std::uint64_t seed, int samples = 40000) {
  RandomU random(seed);
  double sum = 0, squares = 0;
  for (int i = 0; i < samples; ++i) {
    const auto s = light.sample_li(receiver, random.pair());
    const double e = s.value.r * std::fmax(0, dot(n, Vec3(s.wi))) / s.pdf.per_sr;
    sum += e, squares += e * e;
  }
  const double mean = sum / samples;
  const double variance = std::fmax(0, squares / samples - mean * mean);
  return {mean, std::sqrt(variance / samples)};
}
/// The same for a receiver with a position only.
template <typename Light>
Estimate illuminance(const Light& light, const Vec3& receiver, const Vec3& n, std::uint64_t seed,
                     int samples = 40000) {
  return illuminance(light, Receiver(receiver), n, seed, samples);
}

/// Expects `e` within 5.5 standard errors plus 1e-6 of the closed form.  The standard errors alone
/// fail once in 2e7 by chance.  Also expects a standard error below `relative` of the closed form,
/// so that the test notices mistakes.
inline void expect_estimates(const Estimate& e, double closed_form, double relative) {
  EXPECT_LT(e.standard_error, relative * closed_form);
  EXPECT_LE(std::fabs(e.mean - closed_form), 5.5 * e.standard_error + 1e-6 * closed_form)
      << e.mean << " +- " << e.standard_error << ", should be " << closed_form;
}

/// The p-value of a chi-square test of 16 x 16 bins: are values of [0, 1)^2 uniform?  `next()`
/// returns one value.
template <typename Next>
double uniformity_p_value(Next&& next, int samples = 50000) {
  constexpr int kBins = 16;
  std::vector<double> observed(kBins * kBins),
      expected(kBins * kBins, double(samples) / (kBins * kBins));
  for (int i = 0; i < samples; ++i) {
    const Vec2 p = next();
    const auto bin = [](double x) { return std::min(std::max(int(x * kBins), 0), kBins - 1); };
    ++observed[bin(p.x) * kBins + bin(p.y)];
  }
  return chi_square_p_value(observed, expected);
}

/// A correct sampler has a smaller p-value once in 1e7.
inline constexpr double kUnlikely = 1e-7;

}  // namespace lucerna::testing
