// The area light: a shape that emits from its surface, on one side or on both.  Its radiance L is
// uniform, or it varies with
// - a picture on the shape, which multiplies L at each point,
// - a luminaire's photometry on a flat shape, which makes L depend on the direction,
// or with both.
//
// An area A whose radiance L depends only on the direction has the far field A cos(theta) L. The
// luminous intensity I(w) of a file therefore comes from the radiance
//
//   L(w) = I(w) / (A |cos(theta)|),   theta between w and the normal.
//
// Near the panel, the light is that of an evenly bright opening of this size.  Planning programs
// use this area source for a luminaire.  Close to a real luminaire the light differs from it:
// [Ngai87]
#pragma once

#include <absl/status/statusor.h>

#include <concepts>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "lights/models/light.h"
#include "lights/pictures/photometric_web.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape.h"

namespace lucerna {

struct DiffuseEmission {
  /// Per channel, finite, not negative.  With a picture: the radiance of its value 1.  With
  /// photometry: a factor of its radiance, without a unit.
  Rgb radiance_cd_m2;
  bool two_sided = false;
};

/// The photometry of a panel and its orientation.
struct PanelProfile {
  std::shared_ptr<const PhotometricWeb> web;  ///< not null
  /// The direction of photometric +x (the plane C0), world, of any length but 0 and not along the
  /// normal.  Its component along the normal is ignored.  Photometric +z is the normal.
  Vec3 tangent{1, 0, 0};
  bool mirrored = false;  ///< +y is tangent x normal, else normal x tangent
  std::string file, format;
  std::string web_unit{}, flux_unit{};  ///< as GoniometricLightParams has them
};

/// What varies L; neither: uniform.
struct EmissionPattern {
  std::optional<Picture> picture{};
  std::optional<PanelProfile> profile{};
};

/// The photometric axes x, y, z of a profile on a shape.  Errors: normals more than 1e-3 rad from
/// their mean; a tangent that is zero or along the normal.
absl::StatusOr<Frame> photometric_axes(const Shape& shape, const PanelProfile& profile);

/// Points are chosen by a picture where the shape can (Shape::distribution), else in the way that
/// the receiver requests.  Immutable, so safe to share between threads.  Copies share all data.
class AreaLight final : public Light {
 public:
  /// Errors: radiance negative, not finite or beyond the range of `double`; a shape that cannot
  /// emit (`emissive_error`); area zero or not finite; those of `photometric_axes`.
  static absl::StatusOr<AreaLight> create(const DiffuseEmission& emission,
                                          std::shared_ptr<const Shape> shape,
                                          EmissionPattern pattern = {});
  template <std::derived_from<Shape> S>
  static absl::StatusOr<AreaLight> create(const DiffuseEmission& emission, S shape,
                                          EmissionPattern pattern = {}) {
    return create(emission, std::make_shared<const S>(std::move(shape)), std::move(pattern));
  }
  /// The same light with other emission.
  absl::StatusOr<std::shared_ptr<const Light>> with_emission(const DiffuseEmission& emission) const;

  /// A point of the shape seen from `receiver`, with its density with respect to solid angle.
  ///
  /// Reasons without light:
  /// - kBehind: on the dark side of a one-sided light, and in the plane of any light.
  /// - kDegenerate: the receiver lies on the sampled point, or on the triangle, rectangle or disk
  ///   of the point.  On a sphere or a cylinder only if no light arrives from across.
  /// - kBlack: L is 0, or that of the picture is.
  /// - kOutsideCone: the photometry has no light in this direction.
  /// - kOutOfRange: the density or L is not a positive `double`, or the receiver is not finite.
  /// Parts of a closed mesh that face away from the receiver are sampled too.  They give kBehind,
  /// so the mean over all samples is exact.  Without a density `pdf.per_sr` is 1, so value / pdf is
  /// 0.  Without a direction `wi` is 0.
  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;

  /// The density with which sample_li chooses directions.  It sums over all points of the light
  /// along `wi` whose emitting side faces the receiver, including points hidden behind others.  Its
  /// integral is the probability that a sample is not kBehind or kDegenerate.
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const override;

  /// The density with which sample_li chooses this point; 0 where its emitting side faces away.
  /// Rays that find the point are weighted by it.
  SolidAnglePdf pdf_li(const Receiver& receiver, const SurfacePoint& point) const override;

  /// The irradiance [lx] on the side that `receiver` faces, in closed form.  It equals the mean of
  /// samples without occlusion, even by parts of the light itself. Nothing if L varies, for shapes
  /// without such a form, and receivers without a normal or not finite.
  std::optional<Rgb> irradiance(const Receiver& receiver) const override;
  /// Whether parts of it may occlude others: `irradiance` is then an upper bound.
  bool hides_itself() const override { return has_irradiance() && shape_->hides_itself(); }

  /// Upper bounds of the illuminance on the side that `receiver` faces, if the light's nearest part
  /// hides the parts behind it.  They come from the closed form, or from the distance to the
  /// shape's box.
  MostIrradiance most_irradiance(const Receiver& receiver) const override;

  /// Radiance [cd/m2] leaving `point` towards the vector `w` of any length; 0 on the dark side and
  /// along the surface.
  Rgb le(const SurfacePoint& point, const Vec3& w) const override;
  Rgb le_escaped(const Vec3&, const Vec3&) const override { return {}; }
  Rgb le_leaving(const Vec3&, const Vec3&, double) const override { return {}; }

  /// pi L A, twice for a two-sided light.  With photometry: the flux of its file to one side or to
  /// both.  Exact except for bent or folded patches, pictures on patches that are not
  /// parallelograms, and one-sided panels that are not flat.
  Power power(const SceneSphere& scene) const override;
  /// pbrt's Phi, which is pi L A too.  With a picture, L is its mean texel, as if each texel
  /// covered the same area.
  Power power_approximate(const SceneSphere& scene) const override;

  /// A point by area and a direction by its cosine, to either side with equal probability where
  /// both emit. Directions lie off the surface by at least 16 roundings of floats. With photometry
  /// the direction follows the cells of its file; directions along the surface and behind a
  /// one-sided panel give kBehind.  The density belongs to the rounded direction.  kBlack where L
  /// is 0.  kOutOfRange where a density or L is not a positive `double`.  [Pharr23, 14.1.2]
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const override;
  /// The ray that leaves `point`, which may be rounded, towards the unit vector `direction`, with
  /// its value and the density of sample_le.  `slack_m`: as in pdf_le.
  EmissionSample ray_from(const SurfacePoint& point, const Vec3& direction,
                          double slack_m = 0) const override;
  /// Both 0 where `position` is not on the light to within rounding and `slack_m`, or where
  /// `direction` leads to a side that does not emit.  Where parts of the light meet, the nearest
  /// part counts.
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene,
                     double slack_m = 0) const override;

  /// The shape's box, and the cone of its normals widened by a hemisphere.  All directions if both
  /// sides emit; with photometry, the cone of its file.
  std::optional<LightBounds> bounds() const override;
  /// None: illuminance falls off with distance.
  std::optional<double> cross_section_m2(const SceneSphere&) const override { return std::nullopt; }
  LightBytes own_bytes() const override;
  SharedData shared_data() const override;
  std::optional<LightParams> made_from() const override;

  const DiffuseEmission& emission() const { return emission_; }
  const Shape& shape() const { return *shape_; }
  /// Null: none.
  const Picture* picture() const { return painted() ? &painted()->picture : nullptr; }
  const PanelProfile* profile() const { return panel() ? &panel()->profile : nullptr; }

 private:
  struct Painted {
    Picture picture;
    PaintedArea area;
    std::optional<ImageDistribution> distribution;  ///< none: points chosen without the picture
  };
  struct Panel {
    PanelProfile profile;
    Frame axes;  ///< photometric x, y, z
    double area_m2;

    Rgb radiance(const Vec3& w, const Vec3& normal, const Rgb& level) const;
    /// Flux of the front or of both sides [lm].  The front is above the mean plane.
    double flux_lm(bool two_sided) const {
      return two_sided ? profile.web->flux_lm() : profile.web->downward_flux_lm();
    }
  };
  struct Pattern {
    std::optional<Painted> painted;
    std::optional<Panel> panel;
  };

  AreaLight(const DiffuseEmission& emission, std::shared_ptr<const Shape> shape,
            std::shared_ptr<const Pattern> pattern);
  static absl::StatusOr<AreaLight> checked(const DiffuseEmission& emission,
                                           std::shared_ptr<const Shape> shape,
                                           std::shared_ptr<const Pattern> pattern);
  const Painted* painted() const {
    return pattern_ && pattern_->painted ? &*pattern_->painted : nullptr;
  }
  const Panel* panel() const { return pattern_ && pattern_->panel ? &*pattern_->panel : nullptr; }
  /// The picture by which points are chosen; null: without one.
  const Painted* chosen_by() const {
    const Painted* p = painted();
    return p != nullptr && p->distribution ? p : nullptr;
  }
  ShapeSample sample_point(const Receiver& receiver, Vec2 u) const;
  AreaPdf pdf_area(const SurfacePoint& point) const;
  /// The density of `sample_le` at unit vectors `direction` from `point`.
  EmissionPdf emission_pdf(const SurfacePoint& point, const Vec3& direction) const;
  Vec3 emission_direction(const SurfacePoint& point, Vec2 u_direction) const;
  bool emits_towards(const SurfacePoint& point, const Vec3& w) const {
    return emits_to_side(dot(point.normal, w));
  }
  /// The same towards a receiver; `w` leads to it.  Samples and densities use this one test.
  bool emits_towards(const SurfacePoint& point, const Vec3& w, const Vec3& receiver) const;
  bool emits_to_side(double side) const { return side > 0 || (emission_.two_sided && side < 0); }
  double sides() const { return emission_.two_sided ? 2 : 1; }
  bool is_black() const;
  /// The reason why a visible point emits nothing although the light is not black.
  NoLight reason_without() const;
  /// Radiance towards `w` of any length but 0, on a side that emits [cd/m2].
  Rgb radiance_at(const SurfacePoint& point, const Vec3& w) const;

  DiffuseEmission emission_;
  /// A bound of the luminance of its points; with photometry of the factor of its intensity.
  double most_cd_m2_;
  std::shared_ptr<const Shape> shape_;
  std::shared_ptr<const Pattern> pattern_;  ///< null: uniform
};

}  // namespace lucerna
