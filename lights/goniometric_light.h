// The goniometric light: a point whose intensity depends on direction, as a photometric web says.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <string>

#include "lights/light_bounds.h"
#include "lights/light_sample.h"
#include "lights/photometric_web.h"

namespace lucerna {

struct GoniometricLightParams {
  Vec3<double> position_m{};  ///< world
  /// World directions of light space's +x, +y and +z: at right angles, of equal length but 0;
  /// left-handed where the light is mirrored.  +z is where a luminaire's straight down goes, so
  /// that it shines along +z as a spot does.
  Frame<double> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  /// [cd] without a web; with one, what its candela are multiplied by.  Finite, not negative.
  Rgb<double> intensity{};
  std::shared_ptr<const PhotometricWeb> web{};  ///< null: the same in all directions
  std::string file{};                           ///< that the web is from, for people to read
  std::string format{};                         ///< of that file
};

template <std::floating_point Real>
class GoniometricLight {
 public:
  using Params = GoniometricLightParams;
  static constexpr bool kDelta = true;

  /// Errors: a field out of its domain, the web's largest intensity times `intensity` too.
  static absl::StatusOr<GoniometricLight> create(const Params& params,
                                                 const Vec3<double>& origin_m = {});

  /// Luminous intensity [cd] towards the unit vector `w` (world axes, from the light).
  Rgb<Real> intensity(const Vec3<Real>& w) const;

  /// Intensity over distance squared.  kOutsideCone where the web is dark.  [Pharr23, 12.2.3]
  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// Delta: 0 everywhere.
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;

  /// Directions by the web's cells, uniform without a web.
  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const;
  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene) const;

  /// The web's flux, in closed form; 4 pi I without one.  Exact.
  Power power(const SceneSphere& scene) const;
  /// The books sum over the pixels of a map, which is exact as well: the same.
  Power power_approximate(const SceneSphere& scene) const;

  /// A point; the cone that holds all cells with light.
  std::optional<LightBounds<Real>> bounds() const;

  const Params& params() const { return params_; }

 private:
  explicit GoniometricLight(const Params& params, const Vec3<double>& origin_m);
  /// What `intensity` is multiplied by towards `w`, of any length but 0, world axes.
  double distribution(const Vec3<double>& w) const;
  SolidAnglePdf<double> direction_pdf(const Vec3<double>& w) const;
  bool is_black() const;

  Params params_;
  Vec3<Real> position_;
  Frame<double> axes_;  ///< of length 1
};

}  // namespace lucerna
