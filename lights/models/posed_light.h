// A moving light at one moment, evaluated where it stands at its first key frame.
#pragma once

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "lights/maths/motion.h"
#include "lights/models/irradiance.h"
#include "lights/models/light_bounds.h"
#include "lights/sampling/inverse_square.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape.h"

namespace lucerna {

/// Light `L` under a rigid map, with the interface of `L`.  The inverse of `pose` takes receivers
/// to the light's space, and `pose` takes samples back.  Each of the two rounds once.  Under the
/// identity, all results but `bounds` have the bits of `L`.  It refers to the light, which must
/// outlive it.
template <typename L>
class Posed {
 public:
  static constexpr bool kDelta = L::kDelta;

  Posed(const L& light, const Pose& pose) : light_(light), pose_(pose) {}

  LightSample sample_li(const Receiver& receiver, Vec2 u) const {
    LightSample s = light_.sample_li(to_light(receiver), u);
    s.wi = vector(s.wi);
    if (std::isfinite(s.distance)) s.point = point(s.point);
    s.normal = vector(s.normal);
    return s;
  }

  std::optional<Rgb> irradiance(const Receiver& receiver) const requires requires(const L& l) {
    l.irradiance(receiver);
  }
  { return light_.irradiance(to_light(receiver)); }
  bool hides_itself() const requires requires(const L& l) { l.hides_itself(); }
  { return light_.hides_itself(); }

  MostIrradiance most_irradiance(const Receiver& receiver) const requires requires(const L& l) {
    l.most_irradiance(receiver);
  }
  { return light_.most_irradiance(to_light(receiver)); }

  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const {
    return light_.pdf_li(to_light(receiver), inverse_vector(wi));
  }

  SolidAnglePdf pdf_li(const Receiver& receiver, const SurfacePoint& point) const requires
      requires(const L& l) {
    l.pdf_li(receiver, point);
  }
  { return light_.pdf_li(to_light(receiver), to_light(point)); }

  Rgb le(const SurfacePoint& point, const Vec3& w) const requires requires(const L& l) {
    l.le(point, w);
  }
  { return light_.le(to_light(point), inverse_vector(w)); }

  Rgb le_escaped(const Vec3& origin, const Vec3& w) const requires requires(const L& l) {
    l.le_escaped(origin, w);
  }
  { return light_.le_escaped(inverse_point(origin), inverse_vector(w)); }

  Rgb le_leaving(const Vec3& origin, const Vec3& w) const requires requires(const L& l) {
    l.le_leaving(origin, w);
  }
  {
    const Vec3 o = inverse_point(origin), d = inverse_vector(w);
    if constexpr (requires { light_.le_leaving(o, d, 0.0); })
      return light_.le_leaving(o, d, slack_m(origin));
    else
      return light_.le_leaving(o, d);
  }

  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const requires requires(const L& l) {
    l.sample_le(u_position, u_direction, scene);
  }
  { return from_light(light_.sample_le(u_position, u_direction, to_light(scene))); }

  EmissionSample ray_from(const SurfacePoint& point, const Vec3& direction) const requires
      requires(const L& l) {
    l.ray_from(point, direction);
  }
  {
    const SurfacePoint p = to_light(point);
    const Vec3 w = inverse_vector(direction);
    if constexpr (requires { light_.ray_from(p, w, 0.0); })
      return from_light(light_.ray_from(p, w, slack_m(point.position)));
    else
      return from_light(light_.ray_from(p, w));
  }

  /// Positions count as on the light if they are within their own rounding of it.  This is the
  /// rounding at the light's present position.  It may be much larger than the rounding of the
  /// light about its own origin.
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction,
                     const SceneSphere& scene) const requires requires(const L& l) {
    l.pdf_le(position, direction, scene);
  }
  {
    const Vec3 w = inverse_vector(direction), p = inverse_point(position);
    const SceneSphere local = to_light(scene);
    if constexpr (requires { light_.pdf_le(p, w, local, 0.0); }) {
      return light_.pdf_le(p, w, local, slack_m(position));
    } else {
      // A light at one point compares the bits of positions.
      const auto own = light_.bounds();
      if (own && own->lower == own->upper)
        return same_float(position, point(own->lower)) ? light_.pdf_le(own->lower, w, local)
                                                       : EmissionPdf{};
      return light_.pdf_le(p, w, local);
    }
  }

  Power power(const SceneSphere& scene) const { return light_.power(to_light(scene)); }
  Power power_approximate(const SceneSphere& scene) const {
    return light_.power_approximate(to_light(scene));
  }

  /// The bounds of `L`.  The box turns with the light and is enclosed by a box along the axes.  Box
  /// and cone are larger by the possible rounding.
  std::optional<LightBounds> bounds() const {
    std::optional<LightBounds> b = light_.bounds();
    if (!b) return b;
    b->axis = vector(b->axis);
    for (double* angle : {&b->cone_rad, &b->normals_rad})
      *angle = std::min(*angle + 8 * kInputRounding, std::numbers::pi);
    if (b->lower == b->upper) {
      b->lower = b->upper = point(b->lower);
      return b;
    }
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
    for (int c = 0; c < 8; ++c) {
      const Vec3 p = pose_.point({(c & 1) != 0 ? b->upper.x : b->lower.x,
                                  (c & 2) != 0 ? b->upper.y : b->lower.y,
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

 private:
  /// How far rounding may move a position off the light at its present place [m].
  static double slack_m(const Vec3& position) { return 8 * kInputRounding * max_abs(position); }
  Vec3 vector(const Vec3& v) const { return pose_.vector(v); }
  Vec3 point(const Vec3& p) const { return pose_.point(p); }
  Vec3 inverse_vector(const Vec3& v) const { return pose_.inverse_vector(v); }
  Vec3 inverse_point(const Vec3& p) const { return pose_.inverse_point(p); }
  EmissionSample from_light(EmissionSample s) const {
    s.origin = point(s.origin);
    s.direction = vector(s.direction);
    s.normal = vector(s.normal);
    return s;
  }
  Receiver to_light(const Receiver& receiver) const {
    Receiver r = receiver;
    r.position = inverse_point(receiver.position);
    r.normal = inverse_vector(receiver.normal);
    return r;
  }
  SurfacePoint to_light(const SurfacePoint& p) const {
    return {inverse_point(p.position), inverse_vector(p.normal), p.primitive};
  }
  SceneSphere to_light(const SceneSphere& scene) const {
    return {pose_.inverse_point(scene.center_m), scene.radius_m};
  }

  const L& light_;
  Pose pose_;
};

}  // namespace lucerna
