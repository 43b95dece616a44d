// Meshes as the shape of an area light. Primitives are chosen by area, then sampled in the way that
// the receiver requests.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "lights/maths/normal_cone.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/bilinear_patch.h"
#include "lights/shapes/shape.h"
#include "lights/shapes/triangle.h"

namespace lucerna {

/// `Primitive` is Triangle or BilinearPatch.  The order of corners decides the emitting side:
/// the side of the cross product of the first two edges.  Primitives of zero area keep their
/// numbers and are never sampled.  Immutable, so safe to share between threads.
template <typename Primitive>
class Mesh final : public Shape {
 public:
  /// `primitives` are relative to the scene's origin.  `corner_uv`: the (u, v) of each primitive's
  /// corners, in order; empty: (0,0), (1,0), (1,1) for triangles, (0,0), (1,0), (0,1), (1,1) for
  /// patches.  Errors: no primitives, coordinates that are not finite, no area at all, another
  /// number of (u, v) than of corners.
  static absl::StatusOr<Mesh> create(std::vector<Primitive> primitives,
                                     std::vector<Vec2f> corner_uv = {});

  double area() const override { return cumulative_area_.back(); }
  double area_error_m2() const override { return area_error_m2_; }
  absl::Status emissive_error() const override { return absl::OkStatus(); }

  /// A primitive by its share of the area, and a point of it in the way of
  /// `receiver.area_sampling`.  Triangles and rectangles support all ways; other patches only
  /// sampling by area.  Both values of `u` choose the primitive, so floats reach more than 2^24
  /// primitives.
  ShapeSample sample(const Receiver& receiver, Vec2 u) const override;
  /// A primitive by its share of the area, and new sample values within it.
  struct Choice {
    std::size_t index;
    Vec2 u;
  };
  Choice choose(Vec2 u) const;
  /// The part of the area that primitive `i` has.
  double share(std::size_t i) const {
    return (cumulative_area_[i] - (i == 0 ? 0 : cumulative_area_[i - 1])) / area();
  }
  /// The density of `sample` at a point of primitive `point.primitive`.
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const override;

  /// Exact close to the plane.
  std::optional<double> height_over(const SurfacePoint& point, const Vec3& p) const override {
    if (point.primitive >= primitives_.size() || !is_flat(point.primitive)) return std::nullopt;
    return primitives_[point.primitive].height_of(p);
  }

  /// That of its corners, or of the box of a large mesh.
  double height_above(const Vec3& p, const Vec3& n) const override;

  bool touches(const Vec3& p, std::uint32_t primitive) const override {
    return primitive < primitives_.size() && is_flat(primitive) &&
           primitives_[primitive].touches(p);
  }

  /// In the order of the primitives.  It tests each primitive.  Only densities of directions use
  /// it, and they are rare.  Rays use a BVH elsewhere.
  void for_each_hit(const Vec3& position, const Vec3& wi,
                    absl::FunctionRef<void(const SurfacePoint&)> f) const override;

  bool has_closed_form() const override { return true; }
  /// The form is a sum over all primitives, which takes too long for large meshes.
  bool has_fast_closed_form() const override { return size() <= kMany; }
  /// Nothing if a primitive with area is not flat.
  std::optional<double> projected_solid_angle_sr(const Vec3& position, const Vec3& normal,
                                                 bool two_sided) const override;
  /// False if all of it is in one plane, to within the rounding of its corners.  Tests each
  /// primitive.
  bool hides_itself() const override;

  /// 1 / area for triangles, sample_area's density for patches.
  AreaPdf pdf_area(const SurfacePoint& point) const override;
  /// On the nearest primitive, the first of equally near ones.  Tests each primitive.
  std::optional<SurfacePoint> locate(const Vec3& position, double slack_m = 0) const override;
  Vec3 located_normal(const SurfacePoint& p, double /*slack_m*/) const override {
    if constexpr (kAlwaysHasWays) {
      return p.normal;
    } else {
      const auto& patch = primitives_[p.primitive];
      return patch.normal(patch.locate(p.position));
    }
  }
  /// A cone about the mean normal: exact for flat meshes, all directions for closed ones.
  NormalCone normals() const override { return normals_; }
  std::pair<Vec3, Vec3> bounds() const override { return bounds_; }
  std::size_t bytes() const override;
  std::size_t size() const override { return primitives_.size(); }

  Vec2 uv(const SurfacePoint& point) const override;
  PaintedArea painted_area(const Picture& picture) const override;
  std::optional<ImageDistribution> distribution(const Picture& picture) const override;
  SurfacePoint sample_picture(const Picture& picture, const ImageDistribution& distribution,
                              Vec2 u) const override;
  AreaPdf pdf_picture(const Picture& picture, const ImageDistribution& distribution,
                      const SurfacePoint& point) const override;

  const Primitive& primitive(std::size_t i) const { return primitives_[i]; }

 private:
  /// Whether every primitive has all ways of sampling: triangles do, only some patches do.
  static constexpr bool kAlwaysHasWays = std::is_same_v<Primitive, Triangle>;
  static constexpr std::size_t kCorners = kAlwaysHasWays ? 3 : 4;
  /// Primitives of a mesh that is too large for a sum over all of them.
  static constexpr std::size_t kMany = 1024;

  Mesh(std::vector<Primitive> primitives, std::vector<double> cumulative_area, double area_error_m2,
       std::vector<bool> rectangles, std::vector<bool> flat, std::vector<Vec2f> corner_uv);
  /// Whether primitive `i` has other ways to be sampled than by area.
  bool has_ways(std::size_t i) const { return kAlwaysHasWays || rectangles_[i]; }
  bool is_flat(std::size_t i) const { return kAlwaysHasWays || flat_[i]; }
  /// The density of a primitive that is sampled by area.  It uses the receiver's height if there is
  /// one, because close to the plane the cosine to a normal loses all digits.
  double pdf_by_area(const Receiver& receiver, const SurfacePoint& point) const;

  /// The (u, v) of a corner, and the coordinates of a (u, v) on a patch that shows the whole
  /// picture corner to corner.
  Vec2 corner(std::size_t primitive, std::size_t corner) const;
  Vec2 on_patch(std::size_t patch, Vec2 uv) const;
  bool is_corner_to_corner(std::size_t patch) const;
  /// The patch coordinates (0,0), (1,0), (0,1), (1,1) mapped to the (u, v) of its corners.
  Vec2 mixed(std::size_t patch, Vec2 st) const;
  /// For two triangles that show the whole picture together: the picture's corner that the first
  /// triangle does not have.
  std::optional<Vec2> missing_in_first() const;

  NormalCone cone_of_normals() const;
  std::pair<Vec3, Vec3> box() const;

  std::vector<Primitive> primitives_;
  std::vector<double> cumulative_area_;  ///< running sums [m2]
  double area_error_m2_;
  /// For each patch, whether it is a rectangle, and whether it is flat; empty for triangles.
  std::vector<bool> rectangles_, flat_;
  std::vector<Vec2f> corner_uv_;
  NormalCone normals_;
  std::pair<Vec3, Vec3> bounds_;
};

using TriangleMesh = Mesh<Triangle>;
using PatchMesh = Mesh<BilinearPatch>;

extern template class Mesh<Triangle>;
extern template class Mesh<BilinearPatch>;

}  // namespace lucerna
