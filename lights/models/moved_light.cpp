#include "lights/models/moved_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "lights/models/all_lights.h"
#include "lights/sampling/inverse_square.h"
#include "lights/shapes/shape.h"

namespace lucerna {
namespace {

/// How far rounding may move a position off the light at its present place [m].
double slack_at(const Vec3& position) { return 8 * kInputRounding * max_abs(position); }

}  // namespace

LightSample MovedLight::sample_li(const Receiver& receiver, Vec2 u) const {
  LightSample s = light_.sample_li(to_light(receiver), u);
  s.wi = pose_.vector(s.wi);
  if (std::isfinite(s.distance)) s.point = pose_.point(s.point);
  s.normal = pose_.vector(s.normal);
  return s;
}

SolidAnglePdf MovedLight::pdf_li(const Receiver& receiver, const Vec3& wi) const {
  return light_.pdf_li(to_light(receiver), pose_.inverse_vector(wi));
}

SolidAnglePdf MovedLight::pdf_li(const Receiver& receiver, const SurfacePoint& point) const {
  return light_.pdf_li(to_light(receiver), to_light(point));
}

std::optional<Rgb> MovedLight::irradiance(const Receiver& receiver) const {
  return light_.irradiance(to_light(receiver));
}

MostIrradiance MovedLight::most_irradiance(const Receiver& receiver) const {
  return light_.most_irradiance(to_light(receiver));
}

Rgb MovedLight::le(const SurfacePoint& point, const Vec3& w) const {
  return light_.le(to_light(point), pose_.inverse_vector(w));
}

Rgb MovedLight::le_escaped(const Vec3& origin, const Vec3& w) const {
  return light_.le_escaped(pose_.inverse_point(origin), pose_.inverse_vector(w));
}

Rgb MovedLight::le_leaving(const Vec3& origin, const Vec3& w, double slack_m) const {
  return light_.le_leaving(pose_.inverse_point(origin), pose_.inverse_vector(w),
                           slack_m + slack_at(origin));
}

EmissionSample MovedLight::sample_le(Vec2 u_position, Vec2 u_direction,
                                     const SceneSphere& scene) const {
  return from_light(light_.sample_le(u_position, u_direction, to_light(scene)));
}

EmissionSample MovedLight::ray_from(const SurfacePoint& point, const Vec3& w,
                                    double slack_m) const {
  return from_light(light_.ray_from(to_light(point), pose_.inverse_vector(w),
                                    slack_m + slack_at(point.position)));
}

EmissionPdf MovedLight::pdf_le(const Vec3& position, const Vec3& direction,
                               const SceneSphere& scene, double slack_m) const {
  const Vec3 w = pose_.inverse_vector(direction);
  const SceneSphere local = to_light(scene);
  // A light at one point compares the bits of positions.
  if (is_delta())
    if (const auto own = light_.bounds(); own && own->lower == own->upper)
      return same_float(position, pose_.point(own->lower)) ? light_.pdf_le(own->lower, w, local)
                                                           : EmissionPdf{};
  return light_.pdf_le(pose_.inverse_point(position), w, local, slack_m + slack_at(position));
}

Power MovedLight::power(const SceneSphere& scene) const { return light_.power(to_light(scene)); }

Power MovedLight::power_approximate(const SceneSphere& scene) const {
  return light_.power_approximate(to_light(scene));
}

std::optional<LightBounds> MovedLight::bounds() const {
  std::optional<LightBounds> b = light_.bounds();
  if (!b) return b;
  b->axis = pose_.vector(b->axis);
  for (double* angle : {&b->cone_rad, &b->normals_rad})
    *angle = std::min(*angle + 8 * kInputRounding, std::numbers::pi);
  if (b->lower == b->upper) {
    b->lower = b->upper = pose_.point(b->lower);
    return b;
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (int c = 0; c < 8; ++c) {
    const Vec3 p =
        pose_.point({(c & 1) != 0 ? b->upper.x : b->lower.x, (c & 2) != 0 ? b->upper.y : b->lower.y,
                     (c & 4) != 0 ? b->upper.z : b->lower.z});
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const double pad = 8 * std::numeric_limits<double>::epsilon() *
                     (std::max(max_abs(low), max_abs(high)) + max_abs(pose_.shift_m));
  const Vec3 around{pad, pad, pad};
  std::tie(b->lower, b->upper) = rounded_outwards(low - around, high + around);
  return b;
}

std::optional<double> MovedLight::cross_section_m2(const SceneSphere& scene) const {
  return light_.cross_section_m2(to_light(scene));
}

std::optional<LightParams> MovedLight::made_from() const { return light_.made_from(); }

EmissionSample MovedLight::from_light(EmissionSample s) const {
  s.origin = pose_.point(s.origin);
  s.direction = pose_.vector(s.direction);
  s.normal = pose_.vector(s.normal);
  return s;
}

Receiver MovedLight::to_light(const Receiver& receiver) const {
  Receiver r = receiver;
  r.position = pose_.inverse_point(receiver.position);
  r.normal = pose_.inverse_vector(receiver.normal);
  return r;
}

SurfacePoint MovedLight::to_light(const SurfacePoint& p) const {
  return {pose_.inverse_point(p.position), pose_.inverse_vector(p.normal), p.primitive};
}

SceneSphere MovedLight::to_light(const SceneSphere& scene) const {
  return {pose_.inverse_point(scene.center_m), scene.radius_m};
}

}  // namespace lucerna
