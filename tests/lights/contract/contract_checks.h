// Checkers for samples of lights, which return a verdict.  checkers_test.cpp shows that they reject
// wrong inputs.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <vector>

#include "lights/maths/transform.h"
#include "lights/sampling/light_sample.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {

/// The placement of a light and its receivers: all lengths times 2^exponent, then a rigid motion.
struct Placement {
  Transform rigid;
  int exponent = 0;

  Vec3 point(const Vec3& p) const { return rigid.point(scaled(p, exponent)); }
  Vec3 direction(const Vec3& d) const { return rigid.vector(d); }
  double length(double l) const { return std::scalbn(l, exponent); }
  /// World from the light's own space, for shapes that take a transform.
  Transform world_from_light() const {
    const double s = std::scalbn(1.0, exponent);
    return exponent == 0 ? rigid : rigid * *Transform::scale({s, s, s});
  }
};

inline double relative_difference(double a, double b) {
  if (a == b) return 0;
  return std::fabs(a - b) / std::fmax(std::fabs(a), std::fabs(b));
}

inline double relative_difference(const Rgb& a, const Rgb& b) {
  return std::fmax(relative_difference(a.r, b.r),
                   std::fmax(relative_difference(a.g, b.g), relative_difference(a.b, b.b)));
}

inline double distance_between(const Vec3& a, const Vec3& b) { return length(Vec3(a) - Vec3(b)); }

/// A sample may carry no light, with the reason.  It may never hold NaN, an infinity or a negative
/// value.
inline Verdict check_well_formed(const LightSample& s) {
  if (!is_finite(s.value) || s.value.r < 0 || s.value.g < 0 || s.value.b < 0) {
    return {fmt::format("value = ({}, {}, {})", s.value.r, s.value.g, s.value.b)};
  }
  if (s.reason != NoLight::kNone) {
    return {s.value.is_black() ? "" : "a value together with a reason for having none"};
  }
  if (s.value.is_black()) return {"value 0 without a reason"};
  // Each component has three roundings.
  constexpr double kUnit = 4 * std::numeric_limits<double>::epsilon();
  if (!(std::fabs(length(Vec3(s.wi)) - 1) < kUnit)) return {"wi is not a unit vector"};
  if (!(s.distance > 0)) return {fmt::format("distance = {}", s.distance)};
  if (std::isfinite(s.distance) && !is_finite(s.point)) return {"point is not finite"};
  if (s.delta != (s.pdf.per_sr == 0)) return {fmt::format("density = {}", s.pdf.per_sr)};
  if (!s.delta && !(s.pdf.per_sr > 0 && std::isfinite(s.pdf.per_sr))) {
    return {fmt::format("density = {}", s.pdf.per_sr)};
  }
  return {};
}

/// The solid angle of a unit of a region's square at (x, y).
template <typename Domain>
double element_sr(const Domain& region, double x, double y) {
  if constexpr (requires { region.element_sr(x, y); })
    return region.element_sr(x, y);
  else
    return region.solid_angle_sr();
}

/// Checks that a density integrates to the share of samples that carry light.  `sample(u)` returns
/// the sample, `pdf(w)` the density.  The tolerance has two parts.  1e-3 is for the midpoint rule
/// on 720 x 720 cells that a silhouette cuts.  5.5 standard deviations are for the share of
/// samples; they are exceeded less than once in 1e7.
template <typename Domain = Region, typename Sample, typename Pdf>
Verdict check_density_integrates(const Domain& region, Sample&& sample, Pdf&& pdf) {
  constexpr int kSamples = 20000;
  RandomU random(0x5eed);
  int with_light = 0;
  for (int i = 0; i < kSamples; ++i) with_light += sample(random.pair()).reason == NoLight::kNone;
  const double probability = double(with_light) / kSamples;
  constexpr int kGrid = 720;
  double integral = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double x = (i + 0.5) / kGrid, y = (j + 0.5) / kGrid;
      integral += pdf(region.at(x, y)) * element_sr(region, x, y) / (kGrid * kGrid);
    }
  const double tolerance = 1e-3 + 5.5 * std::sqrt(probability * (1 - probability) / kSamples);
  if (probability > 0 && std::fabs(integral - probability) < tolerance) return {};
  return {fmt::format("density integrates to {}, sampled probability {} +- {}", integral,
                      probability, tolerance)};
}

/// Checks that directions of samples follow the density.  Rejects by chance with probability 1e-8.
template <typename Domain = Region, typename Sample, typename Pdf>
Verdict check_samples_follow_density(const Domain& region, Sample&& sample, Pdf&& pdf) {
  constexpr int kSamples = 100000, kColumns = 16, kSub = 30;
  std::vector<double> observed(kColumns * kColumns), expected(kColumns * kColumns);
  RandomU random(0xc41);
  for (int i = 0; i < kSamples; ++i) {
    const auto s = sample(random.pair());
    if (s.reason != NoLight::kNone) continue;
    Vec2 at = region.where(Vec3(s.wi));
    if (!(at.x <= 1 + 1e-5)) return {fmt::format("a sample outside of the region: {}", at.x)};
    const int x = std::min(int(at.x * kColumns), kColumns - 1);
    const int y = std::min(int(at.y * kColumns), kColumns - 1);
    ++observed[x * kColumns + y];
  }
  constexpr int kFine = kColumns * kSub;
  for (int i = 0; i < kFine; ++i) {
    for (int j = 0; j < kFine; ++j) {
      const double x = (i + 0.5) / kFine, y = (j + 0.5) / kFine;
      const double cell = element_sr(region, x, y) / (kFine * kFine);
      expected[(i / kSub) * kColumns + j / kSub] += kSamples * cell * pdf(region.at(x, y));
    }
  }
  const double p = chi_square_p_value(observed, expected);
  if (p > 1e-8) return {};
  return {fmt::format("chi-square: p = {}", p)};
}

/// Checks each sample to `tolerance`.  Its reported density equals the density of its direction.
/// Its value equals `value(wi)`, which does not use the light's code.
template <typename Sample, typename Pdf, typename Value>
Verdict check_sample_agrees(Sample&& sample, Pdf&& pdf, Value&& value, double tolerance) {
  RandomU random(0xa9);
  int with_light = 0;
  for (int i = 0; i < 500; ++i) {
    const auto s = sample(random.pair());
    if (const Verdict v = check_well_formed(s); !v.ok()) return v;
    if (s.reason != NoLight::kNone) continue;
    ++with_light;
    const double reported = s.pdf.per_sr;
    const double evaluated = pdf(s.wi);
    if (!(relative_difference(reported, evaluated) <= tolerance)) {
      return {fmt::format("sample {}: density {}, pdf_li says {}", i, reported, evaluated)};
    }
    const Rgb got(s.value);
    const Rgb expected = value(Vec3(s.wi));
    if (!(relative_difference(got, expected) <= tolerance)) {
      return {fmt::format("sample {}: value ({}, {}, {}), should be ({}, {}, {})", i, got.r, got.g,
                          got.b, expected.r, expected.g, expected.b)};
    }
  }
  return {with_light > 0 ? "" : "no sample carries light"};
}

}  // namespace lucerna::testing
