// A shape with a picture on it, as the shape of an area light.  Its points are chosen by the
// picture's values.
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

/// `Surface` is one of this library's shapes.  Disks, spheres and cylinders map a picture by their
/// own (u, v).  Meshes show all of it on each primitive, or the part that `corner_uv` selects.
///
/// Points are chosen by the picture's filtered luminance:
/// - On cylinders and parallelograms the density is proportional to it.
/// - On disks and spheres it is proportional up to the curvature within a row of texels.
/// - On other patches it is proportional in (u, v).  The same holds for two triangles that show the
///   whole picture together.
/// - Other triangles, folded patches, and patches whose corners are not the picture's corners are
///   sampled as if they had no picture.
///
/// The density is exact in every case.  Immutable, so safe to share between threads.  Copies share
/// all data, so lights without pictures stay small.
template <typename Surface>
class Painted : public Covered<Painted<Surface>, Surface> {
 public:
  /// `corner_uv` has the (u, v) of each primitive's corners, in order. Triangles of a mesh need it.
  /// Patches without it have (0,0), (1,0), (0,1), (1,1). Errors: a number of entries other than the
  /// number of corners; an entry that is not finite.
  static absl::StatusOr<Painted> create(Surface surface, Picture picture,
                                        std::vector<Vec2f> corner_uv = {});

  /// A point chosen by the picture if is_by_picture(), else as `surface()` samples.
  ShapeSample sample(const Receiver& receiver, Vec2 u) const;
  /// The density of `sample` at a point of the surface.
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const;

  /// Density of points chosen without a receiver.
  AreaPdf pdf_area(const SurfacePoint& point) const;
  /// Memory without the picture, which lights share.
  std::size_t bytes() const;
  /// The part of `bytes` from which points are drawn; 0 where they are chosen without the picture.
  std::size_t distribution_bytes() const {
    return data_->distribution ? data_->distribution->bytes() : 0;
  }

  /// The picture's value at a point of the surface.
  Rgb tint(const SurfacePoint& point) const { return data_->picture.at(uv(point)); }
  /// The integral of the picture over the surface.
  const PaintedArea& painted_area() const { return data_->painted_area; }
  /// The picture's (u, v) at a point of the surface.
  Vec2 uv(const SurfacePoint& point) const;

  const Surface& surface() const { return data_->surface; }
  const Picture& picture() const { return data_->picture; }
  /// Whether points are chosen by the picture.
  bool is_by_picture() const { return data_->distribution.has_value(); }

 private:
  struct Data {
    Surface surface;
    Picture picture;
    std::vector<Vec2f> corner_uv;
    std::optional<ImageDistribution> distribution;  ///< none: chosen without the picture
    PaintedArea painted_area;
  };

  explicit Painted(Data data);
  PaintedArea measure() const;
  std::optional<ImageDistribution> distribution() const;
  /// The (u, v) of a patch's corner, and the patch coordinates of a (u, v).  `on_patch` requires a
  /// picture that covers the patch corner to corner.
  Vec2 corner(std::size_t patch, std::size_t corner) const;
  Vec2 on_patch(std::size_t patch, Vec2 uv) const;
  bool is_corner_to_corner(std::size_t patch) const;
  /// For two triangles that show the whole picture together: the picture's corner that the first
  /// triangle does not have.
  std::optional<Vec2> missing_in_first() const;

  std::shared_ptr<const Data> data_;
};

// PaintedTriangleMesh, PaintedSphere and so on.
#define LUCERNA_PAINTED(Shape)           \
  using Painted##Shape = Painted<Shape>; \
  extern template class Painted<Shape>;
LUCERNA_AREA_SHAPES(LUCERNA_PAINTED)
#undef LUCERNA_PAINTED

}  // namespace lucerna
