// The geometry that lights at a point share: the way from a receiver to the point, and the inverse
// square law.
#pragma once

#include <optional>

#include "lights/sampling/light_sample.h"

namespace lucerna {

/// Whether two positions are equal in floats, as requests and rays store them.
inline bool same_float(const Vec3& a, const Vec3& b) { return Vec3f(a) == Vec3f(b); }

/// From a receiver to a point: unit direction and distance [m].  In double, in which squares of
/// floats do not overflow or underflow.
struct Way {
  Vec3 wi;
  double distance_m{};
  /// distance_m squared where that is safe [m2]; else 0.
  double squared_m2{};
};

/// The way along a finite vector that is not zero and whose square is safe.  Nothing for other
/// vectors.
[[gnu::always_inline]] inline std::optional<Way> plain_way(const Vec3& difference) {
  const double squared = dot(difference, difference);
  if (!is_safe_square(squared)) return std::nullopt;
  const double distance = std::sqrt(squared);
  return Way{difference / distance, distance, squared};
}

/// The way along a vector that is not zero and whose square is not safe.  Not inlined, so that the
/// common case can be.
[[gnu::noinline]] inline Way scaled_way(const Vec3& difference) {
  return {scaled_direction(difference), scaled_length(difference), 0};
}

/// Starts the sample of a delta light at `position`.  Sets all fields but `value` if there is a way
/// to it, else the reason: kOutOfRange if the receiver is not finite or too far, kDegenerate if it
/// is at the position.
[[gnu::always_inline]] inline Way find_way(const Vec3& position, const Vec3& receiver,
                                           LightSample& sample) {
  sample.delta = true;
  if (!is_finite(receiver)) {
    sample.reason = NoLight::kOutOfRange;
    return {};
  }
  const Vec3 difference = position - receiver;
  if (difference == Vec3{}) {
    sample.reason = NoLight::kDegenerate;
    return {};
  }
  Way way;
  if (const auto plain = plain_way(difference)) [[likely]]
    way = *plain;
  else
    way = scaled_way(difference);
  sample.wi = way.wi;
  sample.distance = way.distance_m;
  sample.point = position;
  if (!std::isfinite(sample.distance)) sample.reason = NoLight::kOutOfRange;
  return way;
}

/// Sets the value of a started sample to intensity over distance squared, 0 where that underflows
/// `double`.  Otherwise sets the reason: kBlack for no intensity, kOutOfRange where the quotient
/// overflows.
inline void set_inverse_square(const Rgb& intensity_cd, const Way& way, LightSample& sample) {
  if (intensity_cd.is_black()) {
    sample.reason = NoLight::kBlack;
    return;
  }
  // The square may overflow or lose digits.  Two divisions in a row then still work.
  const Rgb value(way.squared_m2 > 0 ? intensity_cd / way.squared_m2
                                     : intensity_cd / way.distance_m / way.distance_m);
  if (!is_finite(value)) {
    sample.reason = NoLight::kOutOfRange;
    return;
  }
  sample.value = value;
}

}  // namespace lucerna
