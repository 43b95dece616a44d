#include "lights/models/area_light.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lights/maths/level_validation.h"
#include "lights/models/all_lights.h"
#include "lights/models/irradiance.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/inverse_square.h"
#include "lights/sampling/sampling.h"

namespace lucerna {
namespace {

bool is_density(SolidAnglePdf pdf) { return pdf.per_sr > 0 && std::isfinite(pdf.per_sr); }

}  // namespace

absl::StatusOr<Frame> photometric_axes(const Shape& shape, const PanelProfile& profile) {
  // A thousandth turns the photometry by less than the precision of its own angles.
  constexpr double kFlat = 1e-3;
  const NormalCone normals = shape.normals();
  if (!(normals.half_angle_rad <= kFlat))
    return absl::InvalidArgumentError(
        fmt::format("panel.surface has normals up to {:.3g} rad from their mean, allowed for a "
                    "profile: flat, up to {} rad",
                    normals.half_angle_rad, kFlat));
  const Vec3 n = normalized(normals.axis);
  const Vec3& t = profile.tangent;
  const Vec3 along = normalized(t);
  const Vec3 s = along - n * dot(along, n);
  if (!is_finite(t) || !(length(s) > kFlat))
    return absl::InvalidArgumentError(fmt::format(
        "panel.tangent = ({}, {}, {}), allowed: finite, not along the normal ({}, {}, {})", t.x,
        t.y, t.z, n.x, n.y, n.z));
  Frame axes;
  axes.n = n;
  axes.s = normalized(s);
  axes.t = profile.mirrored ? cross(axes.s, n) : cross(n, axes.s);
  return axes;
}

AreaLight::AreaLight(const DiffuseEmission& emission, std::shared_ptr<const Shape> shape,
                     std::shared_ptr<const Pattern> pattern)
    : Light(
          {.has_surface = true, .has_irradiance = pattern == nullptr && shape->has_closed_form()}),
      emission_(emission),
      most_cd_m2_(luminance(emission.radiance_cd_m2)),
      shape_(std::move(shape)),
      pattern_(std::move(pattern)) {
  // Points are drawn by the luminance of the picture alone, without the colour of the radiance.
  if (painted() != nullptr)
    most_cd_m2_ =
        emission.radiance_cd_m2.max_component() * luminance(painted()->picture.image->brightest());
}

absl::StatusOr<AreaLight> AreaLight::create(const DiffuseEmission& emission,
                                            std::shared_ptr<const Shape> shape,
                                            EmissionPattern pattern) {
  if (absl::Status status = shape->emissive_error(); !status.ok()) return status;
  if (!pattern.picture && !pattern.profile) return checked(emission, std::move(shape), nullptr);
  auto made = std::make_shared<Pattern>();
  if (pattern.profile) {
    auto axes = photometric_axes(*shape, *pattern.profile);
    if (!axes.ok()) return axes.status();
    made->panel = Panel{*std::move(pattern.profile), *axes, shape->area()};
  }
  if (pattern.picture) {
    const PaintedArea area = shape->painted_area(*pattern.picture);
    auto distribution = shape->distribution(*pattern.picture);
    made->painted = Painted{*std::move(pattern.picture), area, std::move(distribution)};
  }
  return checked(emission, std::move(shape), std::move(made));
}

absl::StatusOr<AreaLight> AreaLight::checked(const DiffuseEmission& emission,
                                             std::shared_ptr<const Shape> shape,
                                             std::shared_ptr<const Pattern> pattern) {
  if (absl::Status status = check_light_value("area.radiance", emission.radiance_cd_m2, "cd/m2");
      !status.ok())
    return status;
  if (pattern != nullptr && pattern->painted) {
    if (absl::Status status = check_light_value(
            "area.radiance of the brightest texel",
            emission.radiance_cd_m2 * pattern->painted->picture.image->brightest(), "cd/m2");
        !status.ok())
      return status;
  }
  if (const double area = shape->area(); !(area > 0) || !std::isfinite(area))
    return absl::InvalidArgumentError(
        fmt::format("area.area_m2 = {} m2, allowed: finite and > 0", area));
  return AreaLight(emission, std::move(shape), std::move(pattern));
}

absl::StatusOr<std::shared_ptr<const Light>> AreaLight::with_emission(
    const DiffuseEmission& emission) const {
  auto changed = checked(emission, shape_, pattern_);
  if (!changed.ok()) return changed.status();
  return std::make_shared<const AreaLight>(*std::move(changed));
}

bool AreaLight::emits_towards(const SurfacePoint& point, const Vec3& w,
                              const Vec3& receiver) const {
  const double side = dot(point.normal, w);
  // Nearly along a flat surface, the rounding of point and normal decides the sign.
  constexpr double kNearly = 8 * std::numeric_limits<double>::epsilon();
  const double scale = std::fmax(max_abs(w), max_abs(point.position));
  if (std::fabs(side) <= kNearly * scale)
    return emits_to_side(shape_->height_over(point, receiver).value_or(side));
  return emits_to_side(side);
}

bool AreaLight::is_black() const {
  if (panel() != nullptr && !(panel()->flux_lm(true) > 0)) return true;
  return emission_.radiance_cd_m2.is_black();
}

NoLight AreaLight::reason_without() const {
  if (painted() != nullptr) return NoLight::kBlack;
  return panel() != nullptr ? NoLight::kOutsideCone : NoLight::kOutOfRange;
}

Rgb AreaLight::Panel::radiance(const Vec3& w, const Vec3& normal, const Rgb& level) const {
  const double cd = profile.web->at(axes.local_from_world(w));
  // Uses the point's own cosine.  The cosine of the mean plane is 0 at slightly different
  // directions.  Not finite along the surface if the file has light in that direction.
  const Rgb radiance = level * (cd > 0 ? cd / std::fabs(dot(w, normal)) / area_m2 : 0);
  return is_finite(radiance) ? radiance : Rgb{};
}

Rgb AreaLight::radiance_at(const SurfacePoint& point, const Vec3& w) const {
  if (pattern_ == nullptr) return emission_.radiance_cd_m2;
  Rgb radiance = emission_.radiance_cd_m2;
  if (painted() != nullptr) radiance = radiance * painted()->picture.at(shape_->uv(point));
  return panel() == nullptr ? radiance : panel()->radiance(normalized(w), point.normal, radiance);
}

ShapeSample AreaLight::sample_point(const Receiver& receiver, Vec2 u) const {
  const Painted* const by = chosen_by();
  if (by == nullptr) return shape_->sample(receiver, u);
  const SurfacePoint point = shape_->sample_picture(by->picture, *by->distribution, u);
  return {point, pdf_seen_from(receiver.position, point, pdf_area(point))};
}

AreaPdf AreaLight::pdf_area(const SurfacePoint& point) const {
  const Painted* const by = chosen_by();
  return by == nullptr ? shape_->pdf_area(point)
                       : shape_->pdf_picture(by->picture, *by->distribution, point);
}

LightSample AreaLight::sample_li(const Receiver& receiver, Vec2 u) const {
  LightSample sample;
  sample.pdf = {1};
  sample.reason = NoLight::kOutOfRange;
  if (!is_finite(receiver.position)) return sample;

  const ShapeSample chosen = sample_point(receiver, u);
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
    sample.reason = sample.value.is_black() ? reason_without() : NoLight::kNone;
  } else if (shape_->touches(receiver.position, chosen.point.primitive)) {
    sample.reason = NoLight::kDegenerate;
  } else if (!emits) {
    sample.reason = NoLight::kBehind;
  }
  return sample;
}

SolidAnglePdf AreaLight::pdf_li(const Receiver& receiver, const Vec3& wi) const {
  if (!is_finite(receiver.position) || !is_finite(wi)) return {0};
  SolidAnglePdf sum;
  shape_->for_each_hit(receiver.position, wi, [&](const SurfacePoint& point) {
    sum.per_sr += pdf_li(receiver, point).per_sr;
  });
  return is_density(sum) ? sum : SolidAnglePdf{0};
}

SolidAnglePdf AreaLight::pdf_li(const Receiver& receiver, const SurfacePoint& point) const {
  if (!is_finite(receiver.position) ||
      !emits_towards(point, receiver.position - point.position, receiver.position))
    return {0};
  const SolidAnglePdf pdf = chosen_by() == nullptr
                                ? shape_->pdf(receiver, point)
                                : pdf_seen_from(receiver.position, point, pdf_area(point));
  return is_density(pdf) ? pdf : SolidAnglePdf{0};
}

std::optional<Rgb> AreaLight::irradiance(const Receiver& receiver) const {
  if (!has_irradiance()) return std::nullopt;
  return irradiance_of(emission_.radiance_cd_m2, receiver, [&](const Vec3& normal) {
    return shape_->projected_solid_angle_sr(receiver.position, normal, emission_.two_sided);
  });
}

// A part dA of radiance L sends L cos(theta) cos(theta') dA / r^2.  The cosine at the receiver is
// at most the part's height over r.  A panel sends at most I cos(theta') / r^2 for the file's
// largest intensity I.
MostIrradiance AreaLight::most_irradiance(const Receiver& receiver) const {
  if (!(most_cd_m2_ > 0) || is_black()) return {};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Vec3 p(receiver.position), n(receiver.normal);
  const bool all_around = n == Vec3{};
  const double height = all_around ? kInfinity : shape_->height_above(p, n);
  if (!(height > 0) || !bounds()->reaches(receiver.position)) return {};
  // The illuminance if this radiance came from all directions.
  double lx =
      panel() != nullptr ? kInfinity : most_cd_m2_ * std::numbers::pi * (all_around ? 4 : 1);
  if (has_irradiance() && shape_->has_fast_closed_form()) {
    if (const auto known = irradiance(receiver)) lx = luminance(*known);
    if (lx == 0) return {};
  } else if (has_irradiance() && shape_->size() == 1) {
    const auto height_m = shape_->height_over({}, receiver.position);
    if (height_m && !emits_to_side(*height_m)) return {};
  }
  const auto [lower, upper] = shape_->bounds();
  const auto outside = [](double at, double from, double to) {
    return std::max({0.0, from - at, at - to});
  };
  const double distance =
      length(Vec3{outside(p.x, lower.x, upper.x), outside(p.y, lower.y, upper.y),
                  outside(p.z, lower.z, upper.z)});
  if (!(distance > 0)) return {lx, kInfinity};
  double most_cd = most_cd_m2_;
  most_cd *= panel() != nullptr ? panel()->profile.web->max_cd() : shape_->area();
  // The density of points of patches and pictures is at least half of the uniform one.
  constexpr double kLeastDensity = 0.5;
  const double sample_lx =
      most_cd / kLeastDensity * std::min(1.0, height / distance) / distance / distance;
  return {std::min(lx, sample_lx), sample_lx};
}

Rgb AreaLight::le(const SurfacePoint& point, const Vec3& w) const {
  const Vec3 v(w);
  return emits_towards(point, v) ? radiance_at(point, v) : Rgb{};
}

Power AreaLight::power(const SceneSphere&) const {
  const Rgb& level = emission_.radiance_cd_m2;
  const double sr = sides() * std::numbers::pi;
  const double area = shape_->area(), area_error = shape_->area_error_m2();
  if (panel() == nullptr) {
    if (painted() == nullptr) return {level * (sr * area), luminance(level) * sr * area_error};
    return {level * painted()->area.m2 * sr, luminance(level) * painted()->area.error_m2 * sr};
  }
  // A flat shape's normals are a few roundings of its vertices apart, and so is their mean.
  constexpr double kRounding = 16 * kInputRounding;
  const double lean = shape_->normals().half_angle_rad;
  // On one side, a point's own hemisphere lacks the directions between its plane and the mean
  // plane.  On the other side it has as many more.
  const double bend_lm = emission_.two_sided || lean <= kRounding
                             ? 0
                             : panel()->profile.web->horizon_flux_bound_lm(lean);
  const double flux_lm = panel()->flux_lm(emission_.two_sided);
  const double of_area = area_error / area;
  if (painted() == nullptr) {
    // The radiance is the file's intensity over the area, and each point's true area multiplies it.
    const Rgb lumens = level * flux_lm;
    return {lumens, luminance(lumens) * of_area + luminance(level) * bend_lm * (1 + of_area)};
  }
  // The mean of the picture multiplies it.
  const Rgb lumens = level * painted()->area.m2 * (flux_lm / area);
  const double brightest = luminance(level * painted()->picture.image->brightest());
  return {lumens, luminance(lumens) * of_area +
                      luminance(level) * painted()->area.error_m2 * (flux_lm / area) +
                      brightest * bend_lm * (1 + of_area)};
}

Power AreaLight::power_approximate(const SceneSphere& scene) const {
  if (painted() == nullptr) return power(scene);
  const Rgb mean = emission_.radiance_cd_m2 * painted()->picture.image->mean();
  const double factor = panel() == nullptr ? sides() * std::numbers::pi * shape_->area()
                                           : panel()->flux_lm(emission_.two_sided);
  return approximate_power(mean * factor, power(scene));
}

EmissionPdf AreaLight::emission_pdf(const SurfacePoint& point, const Vec3& direction) const {
  const Vec3 w(direction);
  if (!emits_towards(point, w)) return {};
  const AreaPdf by_area = pdf_area(point);
  if (panel() != nullptr)
    return {by_area, panel()->profile.web->pdf(panel()->axes.local_from_world(w))};
  const double cosine = std::fabs(dot(point.normal, w));
  return {by_area, {cosine * std::numbers::inv_pi / sides()}};
}

Vec3 AreaLight::emission_direction(const SurfacePoint& point, Vec2 u_direction) const {
  Vec2 u{u_direction.x, u_direction.y};
  if (panel() != nullptr) return panel()->axes.world_from_local(panel()->profile.web->sample(u));
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

EmissionSample AreaLight::sample_le(Vec2 u_position, Vec2 u_direction, const SceneSphere&) const {
  // Sample by area.  The receiver that requests this is inside the shape: from there a sphere has
  // no cone of directions.
  const auto [lower, upper] = shape_->bounds();
  Receiver by_area((lower + upper) * 0.5);
  by_area.area_sampling = AreaSampling::kLowDistortion;
  const SurfacePoint point = sample_point(by_area, u_position).point;
  return ray_from(point, normalized(emission_direction(point, u_direction)));
}

EmissionSample AreaLight::ray_from(const SurfacePoint& given, const Vec3& direction,
                                   double slack_m) const {
  SurfacePoint point = given;
  // The normal that pdf_le will use.  Along the surface, two normals that differ by a rounding give
  // completely different cosines.
  point.normal = shape_->located_normal(point, slack_m);
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
    if (sample.value.is_black()) sample.reason = reason_without();
  }
  if (!std::isfinite(pdf.position.per_m2)) sample.pdf_position = {};
  return sample;
}

EmissionPdf AreaLight::pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere&,
                              double slack_m) const {
  if (!is_finite(position) || !is_finite(direction)) return {};
  const auto point = shape_->locate(position, slack_m);
  if (!point) return {};
  const EmissionPdf pdf = emission_pdf(*point, direction);
  const bool good =
      is_density(pdf.direction) && pdf.position.per_m2 > 0 && std::isfinite(pdf.position.per_m2);
  return good ? pdf : EmissionPdf{};
}

std::optional<LightBounds> AreaLight::bounds() const {
  const auto [lower, upper] = shape_->bounds();
  const NormalCone normals = shape_->normals();
  if (panel() != nullptr) {
    const EmissionCone& file = panel()->profile.web->cone();
    // Each normal has its own hemisphere.
    const double hemisphere = kPi / 2 + normals.half_angle_rad;
    if (emission_.two_sided || file.half_angle_rad <= hemisphere)
      return LightBounds{lower, upper, panel()->axes.world_from_local(file.axis),
                         file.half_angle_rad};
    return LightBounds{lower, upper, panel()->axes.n, hemisphere};
  }
  const double cone = emission_.two_sided ? kPi : std::min(kPi, normals.half_angle_rad + kPi / 2);
  return LightBounds{.lower = lower,
                     .upper = upper,
                     .axis = normals.axis,
                     .cone_rad = cone,
                     .normals_rad = normals.half_angle_rad,
                     .two_sided = emission_.two_sided};
}

LightBytes AreaLight::own_bytes() const {
  LightBytes bytes{.object = sizeof *this, .data = shape_->bytes()};
  if (pattern_ != nullptr) bytes.data += sizeof(Pattern);
  if (const Painted* const by = chosen_by()) {
    bytes.tables = by->distribution->bytes();
    bytes.data += bytes.tables - sizeof *by->distribution;
  }
  return bytes;
}

SharedData AreaLight::shared_data() const {
  return {.image = painted() != nullptr ? painted()->picture.image.get() : nullptr,
          .web = panel() != nullptr ? panel()->profile.web.get() : nullptr};
}

std::optional<LightParams> AreaLight::made_from() const { return std::nullopt; }

}  // namespace lucerna
