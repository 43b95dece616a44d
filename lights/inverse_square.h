// What lights at a point share: the way from a receiver to the point, and the inverse square law.
#pragma once

#include "lights/light_sample.h"

namespace lucerna {

/// Whether two positions are the same as requests and rays tell them.
template <std::floating_point Real>
bool same_float(const Vec3<Real>& a, const Vec3<Real>& b) {
  return Vec3<float>(a) == Vec3<float>(b);
}

/// From a receiver to a point: unit direction and distance [m], in double, where no square of a
/// float over- or underflows.
struct Way {
  Vec3<double> wi;
  double distance_m{};
};

/// Starts the sample of a delta light at `position`: all but `value` where there is a way to it,
/// else the reason.  kOutOfRange where the receiver is not finite or too far, kDegenerate where it
/// is the position itself.
template <std::floating_point Real>
Way find_way(const Vec3<Real>& position, const Vec3<Real>& receiver, LightSample<Real>& sample) {
  sample.delta = true;
  if (!is_finite(receiver)) {
    sample.reason = NoLight::kOutOfRange;
    return {};
  }
  const Vec3<double> difference = Vec3<double>(position) - Vec3<double>(receiver);
  if (difference == Vec3<double>{}) {
    sample.reason = NoLight::kDegenerate;
    return {};
  }
  Way way;
  if constexpr (sizeof(Real) < sizeof(double)) {
    way.distance_m = std::sqrt(dot(difference, difference));
    way.wi = difference * (1 / way.distance_m);
  } else {
    const double squared = dot(difference, difference);
    way.distance_m = is_safe_square(squared) ? std::sqrt(squared) : scaled_length(difference);
    way.wi = is_safe_square(squared) ? difference / way.distance_m : scaled_direction(difference);
  }
  sample.wi = Vec3<Real>(way.wi);
  sample.distance = static_cast<Real>(way.distance_m);
  sample.point = position;
  if (!std::isfinite(sample.distance)) sample.reason = NoLight::kOutOfRange;
  return way;
}

/// Sets the value of a started sample to intensity over distance squared, 0 where that underflows
/// `Real`, or the reason why it is none: kBlack for no intensity, kOutOfRange where the quotient
/// overflows.
template <std::floating_point Real>
void set_inverse_square(const Rgb<double>& intensity_cd, double distance_m,
                        LightSample<Real>& sample) {
  if (intensity_cd.is_black()) {
    sample.reason = NoLight::kBlack;
    return;
  }
  // One division at a time: distance^2 overflows before the quotient does.
  const Rgb<Real> value(intensity_cd / distance_m / distance_m);
  if (!is_finite(value)) {
    sample.reason = NoLight::kOutOfRange;
    return;
  }
  sample.value = value;
}

}  // namespace lucerna
