// The uniform infinite light: radiance L from every direction that geometry leaves open.
#pragma once

#include <absl/status/statusor.h>

#include "lights/light_sample.h"

namespace lucerna {

struct UniformInfiniteLightParams {
  Rgb<double> radiance_cd_m2{};  ///< per channel, finite, not negative
};

template <std::floating_point Real>
class UniformInfiniteLight {
 public:
  using Params = UniformInfiniteLightParams;
  static constexpr bool kDelta = false;

  static absl::StatusOr<UniformInfiniteLight> create(const Params& params,
                                                     const Vec3<double>& origin_m = {});
  /// Uniform over the sphere, density 1 / (4 pi); distance infinite.
  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const;
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;
  /// Radiance [cd/m2] that a ray leaving the scene towards `w` meets.
  Rgb<Real> le_escaped(const Vec3<Real>& w) const;
  /// Flux through the scene's bounding disk from all directions, 4 pi L pi R^2.
  Power power(const SceneSphere& scene) const;
  const Params& params() const { return params_; }

 private:
  explicit UniformInfiniteLight(const Params& params);
  Params params_;
  Rgb<Real> radiance_;
};

}  // namespace lucerna
