// The diffuse area light on any shape of this library.  Its radiance L is the same in every
// direction and everywhere on the surface, on one side or on both.  On a shape with a picture L
// follows the picture.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <variant>

#include "lights/models/light.h"
#include "lights/models/panel.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/area_shape.h"
#include "lights/shapes/painted.h"

namespace lucerna {

struct DiffuseEmission {
  /// Per channel, finite, not negative.  With a picture: the radiance of its value 1.  For a panel:
  /// a factor of its radiance, without a unit.
  Rgb radiance_cd_m2;
  bool two_sided = false;
};

/// One of the shapes of LUCERNA_AREA_SHAPES.
using AnyShape = std::variant<const TriangleMesh*, const PatchMesh*, const Sphere*, const Disk*,
                              const Cylinder*>;

/// A light with a surface that rays may hit.
class SurfaceLight : public Light {
 public:
  const DiffuseEmission& emission() const { return emission_; }
  virtual double area_m2() const = 0;
  /// Its shape, without what covers it.
  virtual AnyShape surface() const = 0;
  /// What covers it; null: nothing.
  virtual const Picture* picture() const = 0;
  virtual const PanelProfile* profile() const = 0;
  /// The same light with other emission.  Errors: as `AreaLight::create`.
  virtual absl::StatusOr<std::shared_ptr<const Light>> with_emission(
      const DiffuseEmission& emission) const = 0;

  Rgb le_escaped(const Vec3&, const Vec3&) const final { return {}; }
  Rgb le_leaving(const Vec3&, const Vec3&, double) const final { return {}; }
  /// None: illuminance falls off with distance.
  std::optional<double> cross_section_m2(const SceneSphere&) const final { return std::nullopt; }
  std::optional<LightParams> made_from() const final;

 protected:
  SurfaceLight(const DiffuseEmission& emission, bool has_irradiance)
      : Light({.has_surface = true, .has_irradiance = has_irradiance}), emission_(emission) {}

  DiffuseEmission emission_;
};

/// `Shape` is an AreaShape (lights/shapes/area_shape.h).  A shape with a picture also has
/// `tint(surface_point)`, `painted_area()` and `picture()`; see lights/shapes/painted.h.  A panel
/// also has the members of lights/models/panel.h.  Immutable, so safe to share between threads.
template <typename Shape>
class AreaLight final : public SurfaceLight {
  static_assert(AreaShape<Shape>);

 public:
  static constexpr bool kHasIrradiance = Shape::kHasProjectedSolidAngle;

  /// Errors: radiance negative, not finite or beyond the range of `double`; a shape that cannot
  /// emit
  /// (`emissive_error`); area zero or not finite.
  static absl::StatusOr<AreaLight> create(const DiffuseEmission& emission, Shape shape);

  /// A point of the shape seen from `receiver`, with its density with respect to solid angle.
  ///
  /// Reasons without light:
  /// - kBehind: on the dark side of a one-sided light, and in the plane of any light.
  /// - kDegenerate: the receiver lies on the sampled point, or on the triangle, rectangle or disk
  ///   of the point.  On a sphere or a cylinder only if no light arrives from across.
  /// - kBlack: L is 0.
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
  /// samples without occlusion, even by parts of the light itself. Nothing for pictures, panels,
  /// shapes without such a form, and receivers without a normal or not finite.
  std::optional<Rgb> irradiance(const Receiver& receiver) const override;
  /// Whether parts of it may occlude others: `irradiance` is then an upper bound.
  bool hides_itself() const override {
    if constexpr (kHasIrradiance) return shape_.hides_itself();
    return false;
  }

  /// Upper bounds of the illuminance on the side that `receiver` faces, if the light's nearest part
  /// hides the parts behind it.  They come from the closed form, or from the distance to the
  /// shape's box.
  MostIrradiance most_irradiance(const Receiver& receiver) const override;

  /// Radiance [cd/m2] leaving `point` towards the vector `w` of any length; 0 on the dark side and
  /// along the surface.
  Rgb le(const SurfacePoint& point, const Vec3& w) const override;

  /// pi L A, twice for a two-sided light.  For a panel: the flux of its file to one side or to
  /// both.  Exact except for bent or folded patches, pictures on patches that are not
  /// parallelograms, and one-sided panels that are not flat.
  Power power(const SceneSphere& scene) const override;

  /// A point by area and a direction by its cosine, to either side with equal probability where
  /// both emit. Directions lie off the surface by at least 16 roundings of floats. For a panel the
  /// direction follows the cells of its file; directions along the surface and behind a one-sided
  /// panel give kBehind.  The density belongs to the rounded direction.  kBlack where L is 0.
  /// kOutOfRange where a density or L is not a positive `double`.  [Pharr23, 14.1.2]
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
  /// pbrt's Phi, which is pi L A too.  With a picture, L is its mean texel, as if each texel
  /// covered the same area.
  Power power_approximate(const SceneSphere& scene) const override;
  /// The shape's box, and the cone of its normals widened by a hemisphere.  All directions if both
  /// sides emit; for a panel, the cone of its file.
  std::optional<LightBounds> bounds() const override;

  LightBytes own_bytes() const override {
    LightBytes bytes{.object = sizeof *this, .data = shape_.bytes()};
    if constexpr (!kPainted && !kPanel) bytes.data -= sizeof shape_;  // counted in the light
    if constexpr (kPainted) bytes.tables = shape_.distribution_bytes();
    return bytes;
  }
  SharedData shared_data() const override {
    SharedData data;
    if constexpr (kPainted) data.image = shape_.picture().image.get();
    if constexpr (kPanel) data.web = shape_.profile().web.get();
    return data;
  }

  double area_m2() const override { return shape_.area(); }
  AnyShape surface() const override {
    if constexpr (kPainted || kPanel)
      return &shape_.surface();
    else
      return &shape_;
  }
  const Picture* picture() const override {
    if constexpr (kPainted) return &shape_.picture();
    return nullptr;
  }
  const PanelProfile* profile() const override {
    if constexpr (kPanel) return &shape_.profile();
    return nullptr;
  }
  absl::StatusOr<std::shared_ptr<const Light>> with_emission(
      const DiffuseEmission& emission) const override;
  const Shape& shape() const { return shape_; }

 private:
  AreaLight(const DiffuseEmission& emission, Shape shape);
  /// The density of `sample_le` at unit vectors `direction` from `point`.
  EmissionPdf emission_pdf(const SurfacePoint& point, const Vec3& direction) const;
  Vec3 emission_direction(const SurfacePoint& point, Vec2 u_direction) const;
  bool emits_towards(const SurfacePoint& point, const Vec3& w) const;
  /// The same towards a receiver; `w` leads to it.  Samples and densities use this one test.
  bool emits_towards(const SurfacePoint& point, const Vec3& w, const Vec3& receiver) const;
  bool emits_to_side(double side) const { return side > 0 || (emission_.two_sided && side < 0); }
  static constexpr bool kPainted = requires(const Shape& s, const SurfacePoint& p) { s.tint(p); };
  static constexpr bool kPanel = requires(const Shape& s) { s.profile(); };
  /// The reason why a visible point emits nothing although the light is not black.
  static constexpr NoLight kWithout = kPainted ? NoLight::kBlack
                                      : kPanel ? NoLight::kOutsideCone
                                               : NoLight::kOutOfRange;
  bool is_black() const;
  /// Radiance towards `w` of any length but 0, on a side that emits [cd/m2].
  Rgb radiance_at(const SurfacePoint& point, const Vec3& w) const;

  Rgb radiance_;
  /// A bound of the luminance of its points; for a panel of the factor of its intensity.
  double most_cd_m2_;
  Shape shape_;
};

// TriangleMeshLight, PaintedTriangleMeshLight, PanelTriangleMeshLight and so on.
#define LUCERNA_AREA_LIGHT(Shape)        \
  using Shape##Light = AreaLight<Shape>; \
  extern template class AreaLight<Shape>;
#define LUCERNA_PAINTED_LIGHT(Shape) LUCERNA_AREA_LIGHT(Painted##Shape)
#define LUCERNA_PANEL_LIGHT(Shape) LUCERNA_AREA_LIGHT(Panel##Shape)
LUCERNA_AREA_SHAPES(LUCERNA_AREA_LIGHT)
LUCERNA_AREA_SHAPES(LUCERNA_PAINTED_LIGHT)
LUCERNA_FLAT_SHAPES(LUCERNA_PANEL_LIGHT)
#undef LUCERNA_AREA_LIGHT
#undef LUCERNA_PAINTED_LIGHT
#undef LUCERNA_PANEL_LIGHT

}  // namespace lucerna
