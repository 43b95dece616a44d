// A shape with a picture on it, as the shape of an area light: its points are chosen by what the
// picture shows there.
#pragma once

#include <absl/status/statusor.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lights/pictures/image_distribution.h"
#include "lights/shapes/area_shape.h"
#include "lights/shapes/covered.h"
#include "lights/shapes/picture.h"

namespace lucerna {

/// `Surface` is one of this library's shapes.  Disks, spheres and cylinders take a picture by their
/// own (u, v); meshes show all of it on each primitive, or what `corner_uv` says.
///
/// Points are chosen by the picture's luminance as its filter shows it: with a density that is
/// proportional to it on cylinders, parallelograms, and up to the curvature within a row of texels
/// on disks and spheres; on other patches proportional to it in (u, v); likewise two triangles
/// that show it together.  Other triangles, folded patches and patches whose corners are not those
/// of the picture are sampled as without it.  The density
/// is exact in every case.  Immutable, so safe to share between threads; copies share all they
/// hold, so that lights without pictures are no larger for those that have one.
template <typename Real, template <typename> typename Surface>
class Painted : public Covered<Painted<Real, Surface>, Real, Surface<Real>> {
 public:
  /// `corner_uv`: of each primitive's corners in its order, triangles of a mesh need them, patches
  /// have (0,0), (1,0), (0,1), (1,1) without.  Errors: a number of them that is not that of the
  /// corners, one that is not finite.
  static absl::StatusOr<Painted> create(Surface<Real> surface, Picture picture,
                                        std::vector<Vec2<float>> corner_uv = {});

  /// By the picture, or as `surface()` does it.
  ShapeSample<Real> sample(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// The density of `sample` at a point of the surface.
  SolidAnglePdf<Real> pdf(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// Density of points that no receiver chooses.
  AreaPdf<double> pdf_area(const SurfacePoint<Real>& point) const;
  /// Without the picture, which lights share.
  std::size_t bytes() const;
  /// Of these, what points are chosen with; 0 where they are chosen without the picture.
  std::size_t distribution_bytes() const {
    return data_->distribution ? data_->distribution->bytes() : 0;
  }

  /// What the picture shows at a point of the surface.
  Rgb<double> tint(const SurfacePoint<Real>& point) const { return data_->picture.at(uv(point)); }
  /// The integral of the picture over the surface.
  const PaintedArea& painted_area() const { return data_->painted_area; }
  /// The picture's (u, v) at a point of the surface.
  Vec2<double> uv(const SurfacePoint<Real>& point) const;

  const Surface<Real>& surface() const { return data_->surface; }
  const Picture& picture() const { return data_->picture; }
  /// Whether points are chosen by the picture.
  bool is_by_picture() const { return data_->distribution.has_value(); }

 private:
  struct Data {
    Surface<Real> surface;
    Picture picture;
    std::vector<Vec2<float>> corner_uv;
    std::optional<ImageDistribution> distribution;  ///< none: chosen without the picture
    PaintedArea painted_area;
  };

  explicit Painted(Data data);
  PaintedArea measure() const;
  std::optional<ImageDistribution> distribution() const;
  /// The (u, v) of a patch's corner, and back from a (u, v) to where it is on the patch; the
  /// latter for pictures that cover the patch corner to corner.
  Vec2<double> corner(std::size_t patch, std::size_t corner) const;
  Vec2<double> on_patch(std::size_t patch, Vec2<double> uv) const;
  bool is_corner_to_corner(std::size_t patch) const;
  /// Of two triangles that show the whole picture together: the corner of it that the first lacks.
  std::optional<Vec2<double>> lacked_by_first() const;

  std::shared_ptr<const Data> data_;
};

// PaintedTriangleMesh, PaintedSphere and so on.
#define LUCERNA_PAINTED(Shape)                 \
  template <typename Real>                     \
  using Painted##Shape = Painted<Real, Shape>; \
  extern template class Painted<float, Shape>; \
  extern template class Painted<double, Shape>;
LUCERNA_AREA_SHAPES(LUCERNA_PAINTED)
#undef LUCERNA_PAINTED

}  // namespace lucerna
