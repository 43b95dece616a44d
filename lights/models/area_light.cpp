#include "lights/models/area_light.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lights/models/all_lights.h"
#include "lights/models/irradiance.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/inverse_square.h"
#include "lights/sampling/sampling.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {
namespace {

bool is_density(SolidAnglePdf pdf) { return pdf.per_sr > 0 && std::isfinite(pdf.per_sr); }

}  // namespace

template <typename Shape>
AreaLight<Shape>::AreaLight(const DiffuseEmission& emission, Shape shape)
    : SurfaceLight(emission, kHasIrradiance),
      radiance_(emission.radiance_cd_m2),
      most_cd_m2_(luminance(emission.radiance_cd_m2)),
      shape_(std::move(shape)) {
  // Points are drawn by the luminance of the picture alone, without the colour of the radiance.
  if constexpr (kPainted)
    most_cd_m2_ =
        emission.radiance_cd_m2.max_component() * luminance(shape_.picture().image->brightest());
}

template <typename Shape>
absl::StatusOr<AreaLight<Shape>> AreaLight<Shape>::create(const DiffuseEmission& emission,
                                                          Shape shape) {
  if (absl::Status status = check_light_value("area.radiance", emission.radiance_cd_m2, "cd/m2");
      !status.ok())
    return status;
  if constexpr (kPainted) {
    if (absl::Status status = check_light_value(
            "area.radiance of the brightest texel",
            emission.radiance_cd_m2 * shape.picture().image->brightest(), "cd/m2");
        !status.ok())
      return status;
  }
  if (absl::Status status = shape.emissive_error(); !status.ok()) return status;
  if (const double area = shape.area(); !(area > 0) || !std::isfinite(area))
    return absl::InvalidArgumentError(
        fmt::format("area.area_m2 = {} m2, allowed: finite and > 0", area));
  return AreaLight(emission, std::move(shape));
}

template <typename Shape>
bool AreaLight<Shape>::emits_towards(const SurfacePoint& point, const Vec3& w) const {
  return emits_to_side(dot(point.normal, w));
}

template <typename Shape>
bool AreaLight<Shape>::emits_towards(const SurfacePoint& point, const Vec3& w,
                                     const Vec3& receiver) const {
  const double side = dot(point.normal, w);
  // Nearly along a flat surface, the rounding of point and normal decides the sign.
  constexpr double kNearly = 8 * std::numeric_limits<double>::epsilon();
  const double scale = std::fmax(max_abs(w), max_abs(point.position));
  if (std::fabs(side) <= kNearly * scale)
    return emits_to_side(shape_.height_over(point, receiver).value_or(side));
  return emits_to_side(side);
}

template <typename Shape>
bool AreaLight<Shape>::is_black() const {
  if constexpr (kPanel)
    if (!(shape_.flux_lm(true) > 0)) return true;
  return emission_.radiance_cd_m2.is_black();
}

template <typename Shape>
Rgb AreaLight<Shape>::radiance_at(const SurfacePoint& point, const Vec3& w) const {
  if constexpr (kPainted) {
    return Rgb(emission_.radiance_cd_m2 * shape_.tint(point));
  } else if constexpr (kPanel) {
    const Rgb radiance(emission_.radiance_cd_m2 * shape_.radiance(normalized(w), point.normal));
    return is_finite(radiance) ? radiance : Rgb{};
  } else {
    return radiance_;
  }
}

template <typename Shape>
LightSample AreaLight<Shape>::sample_li(const Receiver& receiver, Vec2 u) const {
  LightSample sample;
  sample.pdf = {1};
  sample.reason = NoLight::kOutOfRange;
  if (!is_finite(receiver.position)) return sample;

  const ShapeSample chosen = shape_.sample(receiver, u);
  sample.point = chosen.point.position;
  sample.normal = chosen.point.normal;
  sample.primitive = chosen.point.primitive;
  const Vec3 to_light =
      chosen.to_point != Vec3{} ? chosen.to_point : sample.point - receiver.position;
  if (to_light == Vec3{}) {
    sample.reason = NoLight::kDegenerate;
    return sample;
  }
  const auto plain = plain_way(to_light);
  const Way way = plain ? *plain : scaled_way(to_light);
  sample.distance = way.distance_m;
  sample.wi = way.wi;
  if (is_density(chosen.pdf)) sample.pdf = chosen.pdf;

  const bool emits = emits_towards(chosen.point, -to_light, receiver.position);
  if (is_black()) {
    sample.reason = NoLight::kBlack;
  } else if (emits && is_density(chosen.pdf)) {
    sample.value = radiance_at(chosen.point, -to_light);
    sample.reason = sample.value.is_black() ? kWithout : NoLight::kNone;
  } else if (shape_.touches(receiver.position, chosen.point.primitive)) {
    sample.reason = NoLight::kDegenerate;
  } else if (!emits) {
    sample.reason = NoLight::kBehind;
  }
  return sample;
}

template <typename Shape>
SolidAnglePdf AreaLight<Shape>::pdf_li(const Receiver& receiver, const Vec3& wi) const {
  if (!is_finite(receiver.position) || !is_finite(wi)) return {0};
  SolidAnglePdf sum;
  shape_.for_each_hit(receiver.position, wi, [&](const SurfacePoint& point) {
    sum.per_sr += pdf_li(receiver, point).per_sr;
  });
  return is_density(sum) ? sum : SolidAnglePdf{0};
}

template <typename Shape>
SolidAnglePdf AreaLight<Shape>::pdf_li(const Receiver& receiver, const SurfacePoint& point) const {
  if (!is_finite(receiver.position) ||
      !emits_towards(point, receiver.position - point.position, receiver.position))
    return {0};
  const SolidAnglePdf pdf = shape_.pdf(receiver, point);
  return is_density(pdf) ? pdf : SolidAnglePdf{0};
}

template <typename Shape>
std::optional<Rgb> AreaLight<Shape>::irradiance(const Receiver& receiver) const {
  if constexpr (kHasIrradiance)
    return irradiance_of(radiance_, receiver, [&](const Vec3& normal) {
      return shape_.projected_solid_angle_sr(receiver.position, normal, emission_.two_sided);
    });
  else
    return std::nullopt;
}

// A part dA of radiance L sends L cos(theta) cos(theta') dA / r^2.  The cosine at the receiver is
// at most the part's height over r.  A panel sends at most I cos(theta') / r^2 for the file's
// largest intensity I.
template <typename Shape>
MostIrradiance AreaLight<Shape>::most_irradiance(const Receiver& receiver) const {
  if (!(most_cd_m2_ > 0) || is_black()) return {};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Vec3 p(receiver.position), n(receiver.normal);
  const bool all_around = n == Vec3{};
  const double height = all_around ? kInfinity : shape_.height_above(p, n);
  if (!(height > 0) || !bounds()->reaches(receiver.position)) return {};
  // The illuminance if this radiance came from all directions.
  double lx = kPanel ? kInfinity : most_cd_m2_ * std::numbers::pi * (all_around ? 4 : 1);
  constexpr bool kDisk = requires { shape_.height_of(receiver.position); };
  if constexpr (kDisk) {
    // The closed form of a disk that the horizon cuts takes too long.
    if (!emits_to_side(shape_.height_of(receiver.position))) return {};
  } else if constexpr (kHasIrradiance) {
    // A sum over all primitives, which takes too long for large meshes.
    constexpr std::size_t kMany = 1024;
    if (shape_.size() <= kMany)
      if (const auto known = irradiance(receiver)) lx = luminance(Rgb(*known));
    if (lx == 0) return {};
  }
  const auto [lower, upper] = shape_.bounds();
  const auto outside = [](double at, double from, double to) {
    return std::max({0.0, from - at, at - to});
  };
  const double distance =
      length(Vec3{outside(p.x, lower.x, upper.x), outside(p.y, lower.y, upper.y),
                  outside(p.z, lower.z, upper.z)});
  if (!(distance > 0)) return {lx, kInfinity};
  double most_cd = most_cd_m2_;
  if constexpr (kPanel)
    most_cd *= shape_.profile().web->max_cd();
  else
    most_cd *= area_m2();
  // The density of points of patches and pictures is at least half of the uniform one.
  constexpr double kLeastDensity = 0.5;
  const double sample_lx =
      most_cd / kLeastDensity * std::min(1.0, height / distance) / distance / distance;
  return {std::min(lx, sample_lx), sample_lx};
}

template <typename Shape>
Rgb AreaLight<Shape>::le(const SurfacePoint& point, const Vec3& w) const {
  const Vec3 v(w);
  return emits_towards(point, v) ? radiance_at(point, v) : Rgb{};
}

template <typename Shape>
Power AreaLight<Shape>::power(const SceneSphere&) const {
  const double sides = emission_.two_sided ? 2 : 1;
  if constexpr (kPainted) {
    const PaintedArea& painted = shape_.painted_area();
    return {emission_.radiance_cd_m2 * painted.m2 * (sides * std::numbers::pi),
            luminance(emission_.radiance_cd_m2) * painted.error_m2 * (sides * std::numbers::pi)};
  } else if constexpr (kPanel) {
    // The radiance is the file's intensity over the area, and each point's true area multiplies it.
    const Rgb lumens = emission_.radiance_cd_m2 * shape_.flux_lm(emission_.two_sided);
    const double of_area = shape_.area_error_m2() / area_m2();
    const double of_bend =
        luminance(emission_.radiance_cd_m2) * shape_.flux_error_lm(emission_.two_sided);
    return {lumens, luminance(lumens) * of_area + of_bend * (1 + of_area)};
  } else {
    const double sr = sides * std::numbers::pi;
    return {emission_.radiance_cd_m2 * (sr * area_m2()),
            luminance(emission_.radiance_cd_m2) * sr * shape_.area_error_m2()};
  }
}

template <typename Shape>
Power AreaLight<Shape>::power_approximate(const SceneSphere& scene) const {
  if constexpr (kPainted) {
    const double sides = emission_.two_sided ? 2 : 1;
    const Rgb mean = emission_.radiance_cd_m2 * shape_.picture().image->mean();
    return approximate_power(mean * (sides * std::numbers::pi * area_m2()), power(scene));
  } else {
    return power(scene);
  }
}

template <typename Shape>
EmissionPdf AreaLight<Shape>::emission_pdf(const SurfacePoint& point, const Vec3& direction) const {
  const Vec3 w(direction);
  if (!emits_towards(point, w)) return {};
  if constexpr (kPanel) return {{shape_.pdf_area(point).per_m2}, {shape_.pdf_direction(w).per_sr}};
  const double cosine = std::fabs(dot(point.normal, w));
  const double sides = emission_.two_sided ? 2 : 1;
  return {{shape_.pdf_area(point).per_m2}, {cosine * std::numbers::inv_pi / sides}};
}

template <typename Shape>
Vec3 AreaLight<Shape>::emission_direction(const SurfacePoint& point, Vec2 u_direction) const {
  Vec2 u{u_direction.x, u_direction.y};
  if constexpr (kPanel) return shape_.sample_direction(u);
  double side = 1;
  if (emission_.two_sided) {
    side = u.x < 0.5 ? 1 : -1;
    u.x = u.x < 0.5 ? 2 * u.x : 2 * u.x - 1;
  }
  const Vec2 d = sample_concentric_disk(u);
  // Squares map to circles.  The point's distance to the disk's edge equals that of u to the
  // square's edge.  This value is 1 - d.x^2 - d.y^2, which cancels there.
  const double m = 2 * std::min({u.x, 1 - u.x, u.y, 1 - u.y});
  // At the edge the direction stays this many roundings off the surface. Rounded to floats, it
  // still leaves on the same side and has a density.
  constexpr double kLeast = 16 * kInputRounding;
  const double cosine = std::sqrt(std::max(kLeast * kLeast, m * (2 - m)));
  return Frame::around(point.normal).world_from_local({d.x, d.y, side * cosine});
}

template <typename Shape>
EmissionSample AreaLight<Shape>::sample_le(Vec2 u_position, Vec2 u_direction,
                                           const SceneSphere&) const {
  // Sample by area.  The receiver that requests this is inside the shape: from there a sphere has
  // no cone of directions.
  const auto [lower, upper] = shape_.bounds();
  Receiver by_area((lower + upper) * 0.5);
  by_area.area_sampling = AreaSampling::kLowDistortion;
  const SurfacePoint point = shape_.sample(by_area, u_position).point;
  return ray_from(point, normalized(emission_direction(point, u_direction)));
}

template <typename Shape>
EmissionSample AreaLight<Shape>::ray_from(const SurfacePoint& given, const Vec3& direction,
                                          double slack_m) const {
  SurfacePoint point = given;
  // The normal that pdf_le will use.  Along the surface, two normals that differ by a rounding give
  // completely different cosines.
  point.normal = shape_.located_normal(point, slack_m);
  EmissionSample sample;
  sample.origin = point.position;
  sample.normal = point.normal;
  sample.primitive = point.primitive;
  sample.direction = direction;
  const EmissionPdf pdf = emission_pdf(point, sample.direction);
  sample.pdf_position = pdf.position;
  sample.pdf_direction = pdf.direction;
  if (is_black()) {
    sample.reason = NoLight::kBlack;
  } else if (!emits_towards(point, sample.direction)) {
    sample.reason = NoLight::kBehind;
  } else if (!is_density(pdf.direction) || !(pdf.position.per_m2 > 0) ||
             !std::isfinite(pdf.position.per_m2)) {
    sample.reason = NoLight::kOutOfRange;
  } else {
    sample.value = radiance_at(point, sample.direction);
    if (sample.value.is_black()) sample.reason = kWithout;
  }
  if (!std::isfinite(pdf.position.per_m2)) sample.pdf_position = {};
  return sample;
}

template <typename Shape>
EmissionPdf AreaLight<Shape>::pdf_le(const Vec3& position, const Vec3& direction,
                                     const SceneSphere&, double slack_m) const {
  if (!is_finite(position) || !is_finite(direction)) return {};
  const auto point = shape_.locate(position, slack_m);
  if (!point) return {};
  const EmissionPdf pdf = emission_pdf(*point, direction);
  const bool good =
      is_density(pdf.direction) && pdf.position.per_m2 > 0 && std::isfinite(pdf.position.per_m2);
  return good ? pdf : EmissionPdf{};
}

template <typename Shape>
std::optional<LightBounds> AreaLight<Shape>::bounds() const {
  const auto [lower, upper] = shape_.bounds();
  const NormalCone normals = shape_.normals();
  if constexpr (kPanel) {
    const NormalCone cone = shape_.directions(emission_.two_sided);
    return LightBounds{lower, upper, cone.axis, cone.half_angle_rad};
  }
  const double cone = emission_.two_sided ? kPi : std::min(kPi, normals.half_angle_rad + kPi / 2);
  return LightBounds{.lower = lower,
                     .upper = upper,
                     .axis = normals.axis,
                     .cone_rad = cone,
                     .normals_rad = normals.half_angle_rad,
                     .two_sided = emission_.two_sided};
}

template <typename Shape>
absl::StatusOr<std::shared_ptr<const Light>> AreaLight<Shape>::with_emission(
    const DiffuseEmission& emission) const {
  auto changed = create(emission, shape_);
  if (!changed.ok()) return changed.status();
  return std::make_shared<const AreaLight>(*std::move(changed));
}

std::optional<LightParams> SurfaceLight::made_from() const { return std::nullopt; }

#define LUCERNA_AREA_LIGHT(Shape) template class AreaLight<Shape>;
#define LUCERNA_PAINTED_LIGHT(Shape) LUCERNA_AREA_LIGHT(Painted##Shape)
#define LUCERNA_PANEL_LIGHT(Shape) LUCERNA_AREA_LIGHT(Panel##Shape)
LUCERNA_AREA_SHAPES(LUCERNA_AREA_LIGHT)
LUCERNA_AREA_SHAPES(LUCERNA_PAINTED_LIGHT)
LUCERNA_FLAT_SHAPES(LUCERNA_PANEL_LIGHT)

}  // namespace lucerna
