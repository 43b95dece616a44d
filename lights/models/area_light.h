// The diffuse area light on any shape of this library: radiance L, the same in every direction and
// everywhere on the surface, on one side or on both.  On a shape with a picture L is what the
// picture shows.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <optional>

#include "lights/models/light_bounds.h"
#include "lights/models/light_model.h"
#include "lights/models/panel.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/area_shape.h"
#include "lights/shapes/painted.h"

namespace lucerna {

struct DiffuseEmission {
  /// Per channel, finite, not negative.  Of a picture: of its 1; of a panel: what its radiance is
  /// multiplied with, without a unit.
  Rgb<double> radiance_cd_m2;
  bool two_sided = false;
};

/// `Shape` is an AreaShape (lights/shapes/area_shape.h).  One with a picture on it also has
/// `tint(surface_point)`, `painted_area()` and `picture()`; see lights/shapes/painted.h.  A panel
/// also has the members of lights/models/panel.h.  Immutable, so safe to share between threads.
template <std::floating_point Real, template <typename> typename Shape>
class AreaLight {
 public:
  static constexpr bool kDelta = false;
  static constexpr bool kHasIrradiance = Shape<Real>::kHasProjectedSolidAngle;

  /// Errors: radiance negative, not finite or beyond what `Real` holds; a shape that cannot emit
  /// (`emissive_error`); area zero or not finite.
  static absl::StatusOr<AreaLight> create(const DiffuseEmission& emission, Shape<Real> shape);

  /// A point of the shape as `receiver` sees it, density with respect to solid angle.
  ///
  /// kBehind on the dark side of a one-sided light and in the plane of any, kDegenerate where the
  /// receiver lies on the sampled point or on the triangle, rectangle or disk that it was sampled
  /// on (of a sphere or a cylinder: and gets nothing from across), kBlack where L is 0, kOutOfRange
  /// where the density or L is not a positive `Real` or the receiver is not finite.  The parts of a
  /// closed mesh that are turned away from the receiver are sampled like all others and answer
  /// kBehind: the mean over all samples is exact.  Where no density exists, `pdf.per_sr` is 1, so
  /// that value / pdf is 0; where no direction exists, `wi` is 0.
  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const;

  /// The density with which sample_li chooses directions: the sum over all points of the light that
  /// lie along `wi`, hidden behind each other or not, and turn an emitting side to the receiver.
  /// Integrates to the probability of samples that are neither kBehind nor kDegenerate.
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;

  /// The density with which sample_li chooses this very point; 0 where its emitting side is turned
  /// away.  What a ray that found the point weighs itself with.
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// On the side that `receiver` faces, with nothing in the way, not even parts of the light itself
  /// [lx]: the mean of what samples by solid angle say, in closed form.  Nothing for pictures,
  /// panels, shapes without such a form, and where the receiver faces nowhere or is not finite.
  std::optional<Rgb<Real>> irradiance(const Receiver<Real>& receiver) const requires
      HasProjectedSolidAngle<Shape<Real>, Real>;
  /// Whether parts of it may stand before others: `irradiance` is then more than there is.
  bool hides_itself() const requires HasProjectedSolidAngle<Shape<Real>, Real> {
    return shape_.hides_itself();
  }

  /// Radiance [cd/m2] leaving `point` towards the vector `w` of any length; 0 on the dark side and
  /// along the surface.
  Rgb<Real> le(const SurfacePoint<Real>& point, const Vec3<Real>& w) const;

  /// pi L A, twice for a two-sided light; of a panel the flux of its file to that side or both.
  /// Exact, but for bent or folded patches, pictures on patches that are no parallelograms, and
  /// one-sided panels that are not quite flat.
  Power power(const SceneSphere& scene) const;

  /// A point by area, a direction by its cosine, to either side alike where both emit, off the
  /// surface by 16 roundings of floats or more; from a panel by the cells of its file, of which
  /// those along the surface and behind a one-sided one are kBehind.  The density of direction is
  /// that of the rounded direction.  kBlack where L is 0, kOutOfRange where a density or L is not a
  /// positive `Real`.  [Pharr23, 14.1.2]
  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const;
  /// The ray of sample_le that leaves `point`, as it may be rounded, towards the unit vector
  /// `direction`: with what it carries and how densely it is chosen.
  EmissionSample<Real> ray_from(SurfacePoint<Real> point, const Vec3<Real>& direction) const;
  /// Both 0 where `position` is not on the light, to within rounding and `slack_m`, or `direction`
  /// leads to a side that does not emit.  Where parts of the light meet it is the nearest of them
  /// that counts.
  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene, double slack_m = 0) const;
  /// pbrt's Phi, which is pi L A too: the same.  With a picture L is its mean texel, as if the
  /// shape showed each on as much of its area.
  Power power_approximate(const SceneSphere& scene) const;
  /// The shape's box; its normals' cone widened by a hemisphere, all directions where both sides
  /// emit; of a panel the cone of its file.
  std::optional<LightBounds<Real>> bounds() const;

  /// None: illuminance falls off with distance.
  std::optional<double> cross_section_m2(const SceneSphere&) const { return std::nullopt; }
  LightBytes own_bytes() const {
    LightBytes bytes{.all = shape_.bytes()};
    if constexpr (kPainted) bytes.tables = shape_.distribution_bytes();
    return bytes;
  }
  template <typename F>
  void for_each_shared(F&& f) const {
    if constexpr (kPainted) f(*shape_.picture().image);
    if constexpr (kPanel) f(*shape_.profile().web);
  }

  double area_m2() const { return shape_.area(); }
  const DiffuseEmission& emission() const { return emission_; }
  const Shape<Real>& shape() const { return shape_; }

 private:
  AreaLight(const DiffuseEmission& emission, Shape<Real> shape);
  /// The density of `sample_le` at unit vectors `direction` from `point`.
  EmissionPdf<Real> emission_pdf(const SurfacePoint<Real>& point,
                                 const Vec3<Real>& direction) const;
  Vec3<double> emission_direction(const SurfacePoint<Real>& point, Vec2<Real> u_direction) const;
  bool emits_towards(const SurfacePoint<Real>& point, const Vec3<double>& w) const;
  /// The same towards a receiver, `w` the way there: one test for samples and densities.
  bool emits_towards(const SurfacePoint<Real>& point, const Vec3<double>& w,
                     const Vec3<Real>& receiver) const;
  bool emits_to_side(double side) const { return side > 0 || (emission_.two_sided && side < 0); }
  static constexpr bool kPainted = requires(const Shape<Real>& s, const SurfacePoint<Real>& p) {
    s.tint(p);
  };
  static constexpr bool kPanel = requires(const Shape<Real>& s) { s.profile(); };
  /// Why nothing comes from a point that is seen, where the light is not black all over.
  static constexpr NoLight kWithout = kPainted ? NoLight::kBlack
                                      : kPanel ? NoLight::kOutsideCone
                                               : NoLight::kOutOfRange;
  bool is_black() const;
  /// Towards `w` of any length but 0, on a side that emits.
  Rgb<Real> radiance_at(const SurfacePoint<Real>& point, const Vec3<double>& w) const;

  DiffuseEmission emission_;
  Rgb<Real> radiance_;
  Shape<Real> shape_;
};

// TriangleMeshLight, PaintedTriangleMeshLight, PanelTriangleMeshLight and so on.
#define LUCERNA_AREA_LIGHT(Shape)                \
  template <std::floating_point Real>            \
  using Shape##Light = AreaLight<Real, Shape>;   \
  extern template class AreaLight<float, Shape>; \
  extern template class AreaLight<double, Shape>;
#define LUCERNA_PAINTED_LIGHT(Shape) LUCERNA_AREA_LIGHT(Painted##Shape)
#define LUCERNA_PANEL_LIGHT(Shape) LUCERNA_AREA_LIGHT(Panel##Shape)
LUCERNA_AREA_SHAPES(LUCERNA_AREA_LIGHT)
LUCERNA_AREA_SHAPES(LUCERNA_PAINTED_LIGHT)
LUCERNA_FLAT_SHAPES(LUCERNA_PANEL_LIGHT)
#undef LUCERNA_AREA_LIGHT
#undef LUCERNA_PAINTED_LIGHT
#undef LUCERNA_PANEL_LIGHT

}  // namespace lucerna
