// Checkers for the rays that leave a light, for its bounds and for its approximate power, which
// return a verdict.  checkers_test.cpp shows that they reject wrong inputs.
#pragma once

#include <algorithm>
#include <optional>

#include "lights/models/light_bounds.h"
#include "tests/lights/contract/contract_checks.h"

namespace lucerna::testing {

/// A ray may carry no light, with the reason.  It may never hold NaN, an infinity or a negative
/// value.
inline Verdict check_well_formed(const EmissionSample& s) {
  if (!is_finite(s.value) || s.value.r < 0 || s.value.g < 0 || s.value.b < 0)
    return {fmt::format("value = ({}, {}, {})", s.value.r, s.value.g, s.value.b)};
  if (s.reason != NoLight::kNone)
    return {s.value.is_black() ? "" : "a value together with a reason for having none"};
  if (s.value.is_black()) return {"value 0 without a reason"};
  constexpr double kUnit = 4 * std::numeric_limits<double>::epsilon();
  if (!(std::fabs(length(Vec3(s.direction)) - 1) < kUnit))
    return {"direction is not a unit vector"};
  if (!is_finite(s.origin)) return {"origin is not finite"};
  if (s.normal != Vec3{} && !(std::fabs(length(Vec3(s.normal)) - 1) < kUnit))
    return {"normal is not a unit vector"};
  const auto density = [](double p) { return p >= 0 && std::isfinite(p); };
  if (!density(s.pdf_position.per_m2) || !density(s.pdf_direction.per_sr))
    return {fmt::format("densities {} and {}", s.pdf_position.per_m2, s.pdf_direction.per_sr)};
  return {};
}

/// Checks each ray.  Its reported densities equal those of `pdf` to `tolerance`.  Its value equals
/// `value(origin, direction)`, which does not use the light's code, to `value_tolerance`.
template <typename Sample, typename Pdf, typename Value>
Verdict check_emission_agrees(Sample&& sample, Pdf&& pdf, Value&& value, double tolerance,
                              double value_tolerance) {
  RandomU random(0xe1);
  int with_light = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec2 u_position = random.pair();
    const auto s = sample(u_position, random.pair());
    if (const Verdict v = check_well_formed(s); !v.ok()) return v;
    if (s.reason != NoLight::kNone) continue;
    ++with_light;
    const auto densities = pdf(s.origin, s.direction);
    if (!(relative_difference(s.pdf_position.per_m2, densities.position.per_m2) <= tolerance))
      return {fmt::format("ray {}: density of position {}, pdf_le says {}", i,
                          s.pdf_position.per_m2, densities.position.per_m2)};
    if (!(relative_difference(s.pdf_direction.per_sr, densities.direction.per_sr) <= tolerance))
      return {fmt::format("ray {}: density of direction {}, pdf_le says {}", i,
                          s.pdf_direction.per_sr, densities.direction.per_sr)};
    const Rgb got(s.value);
    const Rgb expected = value(Vec3(s.origin), Vec3(s.direction));
    if (!(relative_difference(got, expected) <= value_tolerance))
      return {fmt::format("ray {}: value ({}, {}, {}), should be ({}, {}, {})", i, got.r, got.g,
                          got.b, expected.r, expected.g, expected.b)};
  }
  return {with_light > 0 ? "" : "no ray carries light"};
}

/// Checks that points of the unit square follow a density on it.  `where(i)` returns the i-th
/// point, or nothing if it carries no light; `density(x, y)` returns the density.  Rejects by
/// chance with probability 1e-8.
template <typename Where, typename Density>
Verdict check_follows_on_square(Where&& where, Density&& density) {
  constexpr int kSamples = 100000, kColumns = 16, kSub = 20, kFine = kColumns * kSub;
  std::vector<double> observed(kColumns * kColumns), expected(kColumns * kColumns);
  for (int i = 0; i < kSamples; ++i) {
    const std::optional<Vec2> at = where();
    if (!at) continue;
    if (!(at->x >= -1e-5 && at->x <= 1 + 1e-5 && at->y >= -1e-5 && at->y <= 1 + 1e-5))
      return {fmt::format("a sample outside of the region: ({}, {})", at->x, at->y)};
    const auto column = [](double x) { return std::clamp(int(x * kColumns), 0, kColumns - 1); };
    ++observed[column(at->x) * kColumns + column(at->y)];
  }
  for (int i = 0; i < kFine; ++i) {
    for (int j = 0; j < kFine; ++j) {
      expected[(i / kSub) * kColumns + j / kSub] +=
          kSamples * density((i + 0.5) / kFine, (j + 0.5) / kFine) / (kFine * kFine);
    }
  }
  const double p = chi_square_p_value(observed, expected);
  return {p > 1e-8 ? "" : fmt::format("chi-square: p = {}", p)};
}

/// Checks that the mean of value |cos| / densities is `power`.  The tolerance is 5.5 standard
/// errors, exceeded by chance less than once in 1e7, plus `tolerance` for roundings and for the
/// power itself.
template <typename Sample>
Verdict check_emission_mean(Sample&& sample, const Rgb& power, double tolerance) {
  constexpr int kSamples = 200000;
  RandomU random(0xe2);
  double mean = 0, squares = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 u_position = random.pair();
    const auto s = sample(u_position, random.pair());
    double x = 0;
    if (s.reason == NoLight::kNone) {
      x = luminance(Rgb(s.value));
      if (s.normal != decltype(s.normal){}) x *= std::fabs(dot(Vec3(s.normal), Vec3(s.direction)));
      if (s.pdf_position.per_m2 > 0) x /= s.pdf_position.per_m2;
      if (s.pdf_direction.per_sr > 0) x /= s.pdf_direction.per_sr;
    }
    const double before = x - mean;
    mean += before / (i + 1);
    squares += before * (x - mean);
  }
  const double error = std::sqrt(squares / kSamples / (kSamples - 1));
  const double expected = luminance(power);
  if (std::fabs(mean - expected) <= 5.5 * error + tolerance * expected) return {};
  return {fmt::format("mean {} +- {}, power {}", mean, error, expected)};
}

/// Checks that the bounds reach wherever `arrives(receiver, u)`, at 1e5 random receivers within
/// `size` of `center`, near and far.  Random receivers rarely meet an edge.  So it then searches
/// between lit and dark receivers, down to the last bit.  `reaches(receiver)` is the answer of the
/// bounds.
template <typename Reaches, typename Arrives>
Verdict check_reach(Reaches&& reaches, const Vec3& center, double size, Arrives&& arrives) {
  const auto failure = [](const Vec3& p) {
    return Verdict{
        fmt::format("light arrives at ({}, {}, {}), which the bounds do not reach", p.x, p.y, p.z)};
  };
  RandomU random(0xb0);
  std::optional<Vec3> lit, dark;
  int edges = 0;
  for (int i = 0; i < 100000; ++i) {
    const double distance = size * std::exp(12 * double{random.next()} - 8);
    const Vec2 at = random.pair();
    const Vec3 p(center + Region{}.at(at.x, at.y) * distance);
    const Vec2 u = random.pair();
    if (arrives(p, u)) {
      if (!reaches(p)) return failure(p);
      lit = p;
    } else {
      dark = p;
    }
    if (!lit || !dark || edges >= 2000 || i % 4 != 0) continue;
    ++edges;
    Vec3 inside = *lit, outside = *dark;
    for (int k = 0; k < 60; ++k) {
      const Vec3 middle = (inside + outside) * 0.5;
      (arrives(middle, u) ? inside : outside) = middle;
    }
    if (arrives(inside, u) && !reaches(inside)) return failure(inside);
  }
  return {lit ? "" : "no receiver is lit"};
}

template <typename Arrives>
Verdict check_bounds_reach(const LightBounds& bounds, const Vec3& center, double size,
                           Arrives&& arrives) {
  return check_reach([&](const Vec3& p) { return bounds.reaches(p); }, center, size, arrives);
}

/// Every ray starts in the box and leaves within the cone.
template <typename Sample>
Verdict check_bounds_hold(const LightBounds& bounds, Sample&& sample) {
  RandomU random(0xb1);
  const Vec3 axis(bounds.axis);
  for (int i = 0; i < 20000; ++i) {
    const Vec2 u_position = random.pair();
    const auto s = sample(u_position, random.pair());
    if (s.reason != NoLight::kNone) continue;
    // A sampled direction has a rounding of its own.
    const Vec3 w(s.direction);
    const double angle = std::atan2(length(cross(axis, w)), dot(axis, w));
    if (!(angle <= bounds.cone_rad + 4 * std::numeric_limits<double>::epsilon()))
      return {fmt::format("a ray leaves at {} rad of the axis, the cone has {}", angle,
                          bounds.cone_rad)};
    const double slack = 4 * std::numeric_limits<double>::epsilon() *
                         std::max(max_abs(bounds.lower), max_abs(bounds.upper));
    const auto in = [&](double x, double a, double b) { return x >= a - slack && x <= b + slack; };
    if (!in(s.origin.x, bounds.lower.x, bounds.upper.x) ||
        !in(s.origin.y, bounds.lower.y, bounds.upper.y) ||
        !in(s.origin.z, bounds.lower.z, bounds.upper.z))
      return {fmt::format("a ray starts at ({}, {}, {}), outside of the box", s.origin.x,
                          s.origin.y, s.origin.z)};
  }
  return {};
}

/// The stated error covers the difference to `lumens`, which is known to `relative`.
inline Verdict check_stated_error(const Power& power, const Rgb& lumens, double relative) {
  const double expected = luminance(lumens);
  const double difference = std::fabs(luminance(power.lumens) - expected);
  if (difference <= power.error_lumens + relative * expected) return {};
  return {fmt::format("{} lm stated +- {}, it is {}", luminance(power.lumens), power.error_lumens,
                      expected)};
}

}  // namespace lucerna::testing
