// The goniometric light: a point whose intensity depends on direction, as a photometric web or a
// picture says.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <string>

#include "lights/models/light_bounds.h"
#include "lights/pictures/intensity_map.h"
#include "lights/pictures/photometric_web.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct GoniometricLightParams {
  Vec3<double> position_m{};  ///< world
  /// World directions of light space's +x, +y and +z: at right angles, of equal length but 0;
  /// left-handed where the light is mirrored.  +z is where a luminaire's straight down goes, so
  /// that it shines along +z as a spot does; of a map they are its own axes.
  Frame<double> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  /// [cd] without a file, or of a map's value 1; with a web, what its candela are multiplied by.
  /// Finite, not negative.
  Rgb<double> intensity{};
  /// At most one of them; neither: the same in all directions.
  std::shared_ptr<const PhotometricWeb> web{};
  std::shared_ptr<const IntensityMap> map{};
  std::string file{};    ///< that web or map are from, for people to read
  std::string format{};  ///< of a web's file
};

/// The luminous flux [lm] of a goniometric light whose `intensity` is 1.  Exact.
double flux_of_unit_intensity_lm(const GoniometricLightParams& params);

template <std::floating_point Real>
class GoniometricLight {
 public:
  using Params = GoniometricLightParams;
  static constexpr bool kDelta = true;

  /// Errors: a field out of its domain, the largest intensity of web or map times `intensity` too;
  /// web and map together.
  static absl::StatusOr<GoniometricLight> create(const Params& params,
                                                 const Vec3<double>& origin_m = {});

  /// Luminous intensity [cd] towards the unit vector `w` (world axes, from the light).
  Rgb<Real> intensity(const Vec3<Real>& w) const;
  /// The same, as `value` of the ray that leaves the light towards `w`.
  Rgb<Real> le_leaving(const Vec3<Real>&, const Vec3<Real>& w) const { return intensity(w); }

  /// Intensity over distance squared.  kOutsideCone where web or map are dark.  [Pharr23, 12.2.3]
  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// Delta: 0 everywhere.
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;

  /// Directions by the web's cells or the map's texels; uniform without either.
  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const;
  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene) const;

  /// The flux of web or map, in closed form; 4 pi I without either.  Exact.
  Power power(const SceneSphere& scene) const;
  /// Of maps 4 pi times the mean texel, as the books have it: exact for equal-area ones, too much
  /// for latitude-longitude ones that are brightest at their poles' rows, which are short in truth.
  /// Else as power(), since the books know no webs.  [Pharr23, 12.2.3]
  Power power_approximate(const SceneSphere& scene) const;

  /// A point; the cone that holds all cells or texels with light.
  std::optional<LightBounds<Real>> bounds() const;

  const Params& params() const { return params_; }

 private:
  explicit GoniometricLight(const Params& params, const Vec3<double>& origin_m);
  /// `ask(web)` or `ask(map)`; `otherwise` without either.
  template <typename T, typename Ask>
  T distribution(const T& otherwise, Ask&& ask) const {
    if (params_.web) return ask(*params_.web);
    if (params_.map) return ask(*params_.map);
    return otherwise;
  }
  /// What `intensity` is multiplied by towards `w`, of any length but 0, world axes.
  double share(const Vec3<double>& w) const;
  SolidAnglePdf<double> direction_pdf(const Vec3<double>& w) const;
  bool is_black() const;

  Params params_;
  Vec3<Real> position_;
  Frame<double> axes_;  ///< of length 1
};

}  // namespace lucerna
