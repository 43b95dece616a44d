#include "lights/models/spot_light.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/inverse_square.h"

namespace lucerna {
namespace {

/// Avoids the cancellation of 1 - cos, which is 0 in float below 0.02 degrees.
double one_minus_cos(double angle_rad) {
  const double s = std::sin(angle_rad / 2);
  return 2 * s * s;
}

double profile_at(SpotProfile profile, double x) {
  switch (profile) {
    case SpotProfile::kSmoothstep:
      return x * x * (3 - 2 * x);
    case SpotProfile::kQuadratic:
      return x * x;
    case SpotProfile::kQuartic:
      return x * x * x * x;
  }
  return 0;
}

/// The mean of the profile over x in [0, 1].
double profile_mean(SpotProfile profile) {
  switch (profile) {
    case SpotProfile::kSmoothstep:
      return 1.0 / 2;
    case SpotProfile::kQuadratic:
      return 1.0 / 3;
    case SpotProfile::kQuartic:
      return 1.0 / 5;
  }
  return 0;
}

/// The x below which the share `u` of the integral of smoothstep lies: the root of 2 x^3 - x^4 = u.
/// Newton's method converges from any start because the function is convex.
double invert_smoothstep_integral(double u) {
  double x = std::cbrt(u / 2);
  for (int i = 0; i < 6 && x > 0; ++i) {
    const double f = x * x * x * (2 - x) - u;
    x = std::min(1.0, x - f / (x * x * (6 - 4 * x)));
  }
  return x;
}

/// The x below which the share `u` of the profile's integral lies.
double invert_profile_integral(SpotProfile profile, double u) {
  switch (profile) {
    case SpotProfile::kSmoothstep:
      return invert_smoothstep_integral(u);
    case SpotProfile::kQuadratic:
      return std::cbrt(u);
    case SpotProfile::kQuartic:
      return std::pow(u, 0.2);
  }
  return 0;
}

/// pi - angle, with digits of pi beyond those of a double.  The double nearest to pi counts as pi.
double from_the_back(double angle_rad) {
  constexpr double kRestOfPi = 1.2246467991473532e-16;
  return angle_rad < std::numbers::pi ? (std::numbers::pi - angle_rad) + kRestOfPi : 0;
}

/// Whether the edge is nearer to the back of the light.
bool is_wide(const SpotLightParams& params) {
  return params.cone_half_angle_rad > std::numbers::pi / 2;
}

/// The angle of the edge from the nearer end of the axis.
double from_pole(const SpotLightParams& params) {
  const double cone = params.cone_half_angle_rad;
  return is_wide(params) ? from_the_back(cone) : cone;
}

/// cos s - cos c = 2 sin((c + s) / 2) sin((c - s) / 2), which does not cancel for a narrow edge.
double edge_of(const SpotLightParams& params) {
  const double c = params.cone_half_angle_rad, s = params.falloff_start_rad;
  const double twice_middle = is_wide(params) ? from_the_back(c) + from_the_back(s) : c + s;
  return 2 * std::sin(twice_middle / 2) * std::sin((c - s) / 2);
}

/// a b - c d, with an error of at most two roundings even under cancellation.  [Jeannerod13]
double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d;
  return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

/// `v` scaled by a power of two to a largest component of 1 to 2.
Vec3 of_size_one(const Vec3& v) { return scaled(v, -std::ilogb(max_abs(v))); }

/// The effective solid angle for a given mean of the profile [sr].
double solid_angle_sr(const SpotLightParams& params, double mean) {
  return 2 * std::numbers::pi * (one_minus_cos(params.falloff_start_rad) + edge_of(params) * mean);
}

absl::Status check_angles(const SpotLightParams& params) {
  const double cone = params.cone_half_angle_rad;
  if (!(cone > 0 && cone <= std::numbers::pi)) {
    return absl::InvalidArgumentError(
        fmt::format("spot.cone_half_angle = {} rad, allowed (0, pi]", cone));
  }
  const double start = params.falloff_start_rad;
  if (!(start >= 0 && start <= cone)) {
    return absl::InvalidArgumentError(fmt::format(
        "spot.falloff_start = {} rad, allowed [0, {}], the cone's half angle", start, cone));
  }
  return absl::OkStatus();
}

}  // namespace

SpotLightParams in_space(SpotLightParams params, const Deformation& map) {
  params.axis = map.own_from_world(params.axis);
  params.own_space = nullptr;
  return params;
}

double effective_solid_angle_sr(const SpotLightParams& params) {
  return solid_angle_sr(params, profile_mean(params.profile));
}

absl::Status SpotIntensity::check(const Params& params, const Vec3& origin_m) {
  if (auto s = check_position("spot.position", params.position_m, origin_m); !s.ok()) {
    return s;
  }
  if (auto s = check_direction("spot.axis", params.axis); !s.ok()) return s;
  if (auto s = check_light_value("spot.intensity", params.intensity_cd, "cd"); !s.ok()) {
    return s;
  }
  return check_angles(params);
}

SpotIntensity::SpotIntensity(const Params& params)
    : params_(params),
      axis_(normalized(params.axis)),
      is_wide_(is_wide(params)),
      pole_(is_wide_ ? -axis_ : axis_),
      to_cone_(one_minus_cos(from_pole(params))),
      is_narrow_(from_pole(params) < 1e-3),
      pole_as_given_(of_size_one(is_wide_ ? -params.axis : params.axis)),
      one_minus_cos_start_(one_minus_cos(params.falloff_start_rad)),
      effective_sr_(effective_solid_angle_sr(params)),
      edge_(edge_of(params)),
      per_edge_(edge_ > 0 ? 1 / edge_ : 0) {
  // If the edge is so narrow that its reciprocal overflows, treat it as hard.
  if (!std::isfinite(per_edge_)) edge_ = per_edge_ = 0;
}

double SpotIntensity::one_minus_cos_to_pole(const Vec3& w) const {
  // The narrowest cones are not wider than 1e-16, the error of a unit vector.  The sine therefore
  // comes from the given vectors, and 1 - cos = sin^2 / (1 + cos).
  const Vec3 a = pole_as_given_, v = of_size_one(w);
  const Vec3 across{difference_of_products(v.y, a.z, v.z, a.y),
                    difference_of_products(v.z, a.x, v.x, a.z),
                    difference_of_products(v.x, a.y, v.y, a.x)};
  const double lengths = std::sqrt(dot(a, a) * dot(v, v));
  const double cos = dot(a, v) / lengths;
  if (cos < 0) return 1 - cos;
  const double sin = length(across) / lengths;
  return sin / (1 + cos) * sin;
}

double SpotIntensity::falloff(const Vec3& w) const {
  // 1 - cos of the angle between unit vectors is half the square of their chord, exact near the
  // pole.
  const Vec3 chord = w - pole_;
  const double to_w = is_narrow_ ? one_minus_cos_to_pole(w) : std::min(2.0, dot(chord, chord) / 2);
  const double inside = is_wide_ ? to_w - to_cone_ : to_cone_ - to_w;
  if (edge_ <= 0) return inside >= 0 ? 1 : 0;
  return profile_at(params_.profile, std::clamp(inside * per_edge_, 0.0, 1.0));
}

Rgb SpotIntensity::intensity(const Vec3& w) const {
  // The narrowest cones are not wider than the error of the length of a direction in floats.
  const Vec3 direction = falloff_direction(w);
  if (!is_finite(direction) || direction == Vec3{}) return {};
  return Rgb(params_.intensity_cd * falloff(direction));
}

std::optional<Rgb> SpotIntensity::towards(const Vec3& w, const Vec3& v) const {
  const double share = falloff(is_narrow_ ? v : w);
  if (!(share > 0)) return std::nullopt;
  return params_.intensity_cd * share;
}

Power SpotIntensity::power() const { return {params_.intensity_cd * effective_sr_, 0}; }

Power SpotIntensity::power_approximate() const {
  return approximate_power(params_.intensity_cd * solid_angle_sr(params_, 0.5), power());
}

void SpotIntensity::sample(Vec2 u_direction, EmissionSample& sample) const {
  // The first share of u covers the full light, the rest the edge, from the inside out.  The end of
  // a soft edge has no light and is left out.
  const double u = std::min(double{u_direction.x}, 1 - 0x1p-53);
  const double full = 2 * std::numbers::pi * one_minus_cos_start_ / effective_sr_;
  double h = one_minus_cos_start_, share = 1;
  if (u <= full) {
    h *= full > 0 ? u / full : 0;
  } else {
    const double x = invert_profile_integral(params_.profile, std::min(1.0, (1 - u) / (1 - full)));
    h += (1 - x) * edge_;
    share = profile_at(params_.profile, x);
  }
  const double phi = 2 * std::numbers::pi * u_direction.y;
  const auto radius = [](double h) { return std::sqrt(std::max(0.0, h * (2 - h))); };
  const auto at = [&](double h) {
    const Vec3 local{radius(h) * std::cos(phi), radius(h) * std::sin(phi), 1 - h};
    return Frame::around(axis_).world_from_local(local);
  };
  sample.direction = at(h);
  double rounded = falloff(falloff_direction(sample.direction));
  // If rounding led out of the cone, move inwards by a few roundings, if the cone is that wide.
  constexpr double kInwards = 8 * std::numeric_limits<double>::epsilon();
  if (share > 0 && !(rounded > 0) && radius(h) > kInwards) {
    const Vec3 within = at(h - kInwards * radius(h));
    rounded = falloff(falloff_direction(within));
    if (rounded > 0) sample.direction = within;
  }
  // The density belongs to the rounded direction, as in per_sr.  If the cone is so narrow that
  // rounding always leaves it, the sample keeps its value.
  if (rounded > 0) share = rounded;
  sample.value = Rgb(params_.intensity_cd * share);
  sample.pdf_direction = {share / effective_sr_};
  if (!(share > 0)) sample.reason = NoLight::kOutsideCone;
  if (!(sample.pdf_direction.per_sr > 0) || sample.value.is_black() ||
      !std::isfinite(sample.pdf_direction.per_sr)) {
    if (sample.reason == NoLight::kNone) sample.reason = NoLight::kOutOfRange;
    sample.value = {};
  }
}

double SpotIntensity::per_sr(const Vec3& direction) const {
  const Vec3 w = falloff_direction(direction);
  if (!is_finite(w) || w == Vec3{} || is_black()) return 0;
  return falloff(w) / effective_sr_;
}

EmissionCone SpotIntensity::cone() const {
  // Wider by the rounding of the axis and of a direction; near pi also by the error of cosines.
  double turned = 4 * kInputRounding;
  if (params_.cone_half_angle_rad > std::numbers::pi / 2)
    turned += 16 * std::numeric_limits<double>::epsilon() /
              std::max(std::sin(params_.cone_half_angle_rad), 1e-8);
  return {axis_, std::min(params_.cone_half_angle_rad + turned, std::numbers::pi)};
}

template class IntensityLight<SpotIntensity>;

}  // namespace lucerna
