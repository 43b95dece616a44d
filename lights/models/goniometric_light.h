// The goniometric light: a point whose intensity depends on direction, by a photometric web or a
// picture.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "lights/models/intensity_light.h"
#include "lights/pictures/intensity_map.h"
#include "lights/pictures/photometric_web.h"

namespace lucerna {

struct GoniometricLightParams {
  Vec3 position_m{};  ///< world
  /// World directions of light space's +x, +y and +z: at right angles, of equal length but 0.
  /// Left-handed for a mirrored light.  +z is straight down in the photometry of a luminaire, so a
  /// luminaire shines along +z, like a spot.  For a map they are the map's own axes.
  Frame axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  /// Finite, not negative.  Without a file, and for a map's value 1: [cd].  With a web: the factor
  /// of its candela, without a unit.
  Rgb intensity{};
  /// At most one of them.  Without both: the same intensity in all directions.
  std::shared_ptr<const PhotometricWeb> web{};
  std::shared_ptr<const IntensityMap> map{};
  std::string file{};    ///< name of the web's or map's file, for people to read
  std::string format{};  ///< of the web's file
  /// Units of the flux of the web and of the light, such as "mW"; empty: lm.  They differ if the
  /// light's level comes from a flux in lm.
  std::string web_unit{}, flux_unit{};
  std::shared_ptr<const Frame> own_space{};  ///< see Deformable

  Rgb& level() { return intensity; }
  void apply(const LightMover& move) {
    move.point(position_m), move.frame(axes), move.frame(own_space);
  }
};

GoniometricLightParams in_space(GoniometricLightParams params, const Deformation& map);

/// The luminous flux [lm] of a goniometric light whose `intensity` is 1.  Exact.
double flux_of_unit_intensity_lm(const GoniometricLightParams& params);

class GoniometricIntensity {
 public:
  using Params = GoniometricLightParams;

  explicit GoniometricIntensity(const Params& params);
  /// Errors: a field out of its domain; the largest intensity of web or map times `intensity` out
  /// of its domain; web and map together.
  static absl::Status check(const Params& params, const Vec3& origin_m);

  /// Luminous intensity [cd] towards the unit vector `w`.  [Pharr23, 12.2.3]
  Rgb intensity(const Vec3& w) const;

  bool is_black() const;
  std::optional<Rgb> towards(const Vec3& w, const Vec3& v) const;

  /// Directions by the web's cells or the map's texels; uniform without both.
  void sample(Vec2 u, EmissionSample& ray) const;
  double per_sr(const Vec3& w) const;

  /// The flux of web or map in closed form, or 4 pi I without both.  Exact.
  Power power() const;
  /// For maps 4 pi times the mean texel, as in the books.  Exact for equal-area maps.  Too high for
  /// latitude-longitude maps that are brightest near their poles, where rows are shorter.  For webs
  /// the same as power(), because the books do not have them.  [Pharr23, 12.2.3]
  Power power_approximate() const;
  /// The cone that holds all cells or texels with light.
  EmissionCone cone() const;

  std::uint64_t table_bytes() const { return 0; }
  SharedData shared_data() const {
    return {.image = params_.map ? &params_.map->sphere_map().image() : nullptr,
            .web = params_.web.get(),
            .map = params_.map.get()};
  }

  const Params& params() const { return params_; }

 private:
  /// `use(web)` or `use(map)`; `otherwise` without both.
  template <typename T, typename Use>
  T distribution(const T& otherwise, Use&& use) const {
    if (params_.web) return use(*params_.web);
    if (params_.map) return use(*params_.map);
    return otherwise;
  }
  /// The factor of `intensity` towards `w`, of any length but 0, world axes.
  double share(const Vec3& w) const;
  SolidAnglePdf direction_pdf(const Vec3& w) const;

  Params params_;
  Frame axes_;  ///< of length 1
};

using GoniometricLight = IntensityLight<GoniometricIntensity>;
extern template class IntensityLight<GoniometricIntensity>;

}  // namespace lucerna
