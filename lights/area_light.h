// The diffuse area light on any shape of this library: radiance L, the same in every direction and
// everywhere on the surface, on one side or on both.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>

#include "lights/light_sample.h"

namespace lucerna {

struct DiffuseEmission {
  Rgb<double> radiance_cd_m2;  ///< per channel, finite, not negative
  bool two_sided = false;
};

/// `Shape` owes: `area()`, `sample(receiver, u)`, `pdf(receiver, surface_point)`,
/// `for_each_hit(receiver, wi, f)`, `bytes()`; see lights/sphere.h.
template <std::floating_point Real, template <typename> typename Shape>
class AreaLight {
 public:
  static constexpr bool kDelta = false;

  /// Errors: radiance negative or not finite, area zero or not finite.
  static absl::StatusOr<AreaLight> create(const DiffuseEmission& emission, Shape<Real> shape);

  /// A point of the shape as `receiver` sees it, density with respect to solid angle.
  /// kBehind on the dark side of a one-sided light, kDegenerate where the receiver lies on the
  /// sampled point, kBlack where L is 0.
  LightSample<Real> sample_li(const Vec3<Real>& receiver, Vec2<Real> u) const;

  /// The density with which sample_li chooses directions: the sum over all points of the light that
  /// lie along `wi`, hidden behind each other or not, and turn an emitting side to the receiver.
  SolidAnglePdf<Real> pdf_li(const Vec3<Real>& receiver, const Vec3<Real>& wi) const;

  /// The density with which sample_li chooses this very point; 0 where its emitting side is turned
  /// away.  What a ray that found the point weighs itself with.
  SolidAnglePdf<Real> pdf_li(const Vec3<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// Radiance [cd/m2] leaving `point` towards the unit vector `w`; 0 on the dark side.
  Rgb<Real> le(const SurfacePoint<Real>& point, const Vec3<Real>& w) const;

  /// pi L A, twice for a two-sided light; exact.
  Power power(const SceneSphere& scene) const;

  double area_m2() const;
  const DiffuseEmission& emission() const { return emission_; }
  const Shape<Real>& shape() const { return shape_; }

 private:
  AreaLight(const DiffuseEmission& emission, Shape<Real> shape);
  DiffuseEmission emission_;
  Rgb<Real> radiance_;
  Shape<Real> shape_;
};

}  // namespace lucerna
