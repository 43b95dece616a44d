// A light that moves, at one moment: evaluated where it stands at its first key frame.
#pragma once

#include "lights/light_sample.h"
#include "lights/motion.h"

namespace lucerna {

/// Light `L` under a rigid map, with the interface of `L`.  Receivers go to the light's space by
/// the inverse of `pose`, samples come back by it, rounded once each way.  Under the identity the
/// bits are those of `L`.  Refers to the light: to be used while that lives.
template <std::floating_point Real, typename L>
class Posed {
 public:
  static constexpr bool kDelta = L::kDelta;

  Posed(const L& light, const Pose& pose) : light_(light), pose_(pose) {}

  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const {
    LightSample<Real> s = light_.sample_li(to_light(receiver), u);
    s.wi = vector(s.wi);
    if (std::isfinite(s.distance)) s.point = point(s.point);
    s.normal = vector(s.normal);
    return s;
  }

  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const {
    return light_.pdf_li(to_light(receiver), inverse_vector(wi));
  }

  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver,
                             const SurfacePoint<Real>& point) const requires requires(const L& l) {
    l.pdf_li(receiver, point);
  }
  { return light_.pdf_li(to_light(receiver), to_light(point)); }

  Rgb<Real> le(const SurfacePoint<Real>& point, const Vec3<Real>& w) const requires
      requires(const L& l) {
    l.le(point, w);
  }
  { return light_.le(to_light(point), inverse_vector(w)); }

  Rgb<Real> le_escaped(const Vec3<Real>& origin, const Vec3<Real>& w) const requires
      requires(const L& l) {
    l.le_escaped(origin, w);
  }
  { return light_.le_escaped(inverse_point(origin), inverse_vector(w)); }

  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const requires requires(const L& l) {
    l.sample_le(u_position, u_direction, scene);
  }
  {
    EmissionSample<Real> s = light_.sample_le(u_position, u_direction, to_light(scene));
    s.origin = point(s.origin);
    s.direction = vector(s.direction);
    s.normal = vector(s.normal);
    return s;
  }

  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene) const requires requires(const L& l) {
    l.pdf_le(position, direction, scene);
  }
  { return light_.pdf_le(inverse_point(position), inverse_vector(direction), to_light(scene)); }

  Power power(const SceneSphere& scene) const { return light_.power(to_light(scene)); }

 private:
  Vec3<Real> vector(const Vec3<Real>& v) const { return Vec3<Real>(pose_.vector(Vec3<double>(v))); }
  Vec3<Real> point(const Vec3<Real>& p) const { return Vec3<Real>(pose_.point(Vec3<double>(p))); }
  Vec3<Real> inverse_vector(const Vec3<Real>& v) const {
    return Vec3<Real>(pose_.inverse_vector(Vec3<double>(v)));
  }
  Vec3<Real> inverse_point(const Vec3<Real>& p) const {
    return Vec3<Real>(pose_.inverse_point(Vec3<double>(p)));
  }
  Receiver<Real> to_light(const Receiver<Real>& receiver) const {
    Receiver<Real> r = receiver;
    r.position = inverse_point(receiver.position);
    r.normal = inverse_vector(receiver.normal);
    return r;
  }
  SurfacePoint<Real> to_light(const SurfacePoint<Real>& p) const {
    return {inverse_point(p.position), inverse_vector(p.normal), p.primitive};
  }
  SceneSphere to_light(const SceneSphere& scene) const {
    return {pose_.inverse_point(scene.center_m), scene.radius_m};
  }

  const L& light_;
  Pose pose_;
};

}  // namespace lucerna
