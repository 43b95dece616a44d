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
class Mesh {
 public:
  static constexpr bool kHasProjectedSolidAngle = true;

  /// `primitives` are relative to the scene's origin.  Errors: no primitives, coordinates that are
  /// not finite, no area at all.
  static absl::StatusOr<Mesh> create(std::vector<Primitive> primitives);

  /// The area [m2].
  double area() const { return cumulative_area_.back(); }
  /// Bound on the error of `area`, 0 where it is exact [m2].
  double area_error_m2() const { return area_error_m2_; }
  /// Always OK.
  absl::Status emissive_error() const { return absl::OkStatus(); }

  /// A primitive by its share of the area, and a point of it in the way of
  /// `receiver.area_sampling`.  Triangles and rectangles support all ways; other patches only
  /// sampling by area.  Both values of `u` choose the primitive, so floats reach more than 2^24
  /// primitives.
  ShapeSample sample(const Receiver& receiver, Vec2 u) const;
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
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const;

  /// How far `p` is above the plane of the primitive of `point`, if that is flat.  Exact close to
  /// the plane.
  std::optional<double> height_over(const SurfacePoint& point, const Vec3& p) const {
    if (point.primitive >= primitives_.size() || !is_flat(point.primitive)) return std::nullopt;
    return primitives_[point.primitive].height_of(p);
  }

  /// A bound on the height of its points over the plane through `p` with the unit normal `n` [m]:
  /// that of its corners, or of the box of a large mesh.
  double height_above(const Vec3& p, const Vec3& n) const;

  /// Whether `p` lies on a flat primitive, which it then sees edge-on.
  bool touches(const Vec3& p, std::uint32_t primitive) const {
    return primitive < primitives_.size() && is_flat(primitive) &&
           primitives_[primitive].touches(p);
  }

  /// Calls `f(surface_point)` for every point of the mesh along the unit vector `wi`, in the order
  /// of the primitives.  It tests each primitive.  Only densities of directions use it, and they
  /// are rare.  Rays use a BVH elsewhere.
  template <typename F>
  void for_each_hit(const Vec3& receiver, const Vec3& wi, F&& f) const {
    for (std::size_t i = 0; i < primitives_.size(); ++i) {
      auto found = primitives_[i].hits(receiver, wi, 0, std::numeric_limits<double>::infinity());
      for (int k = 0; k < found.count; ++k) {
        found.hit[k].point.primitive = static_cast<std::uint32_t>(i);
        f(found.hit[k].point);
      }
    }
  }

  /// The projected solid angle [sr] of all sides that emit towards `position`, above the horizon of
  /// the unit vector `normal`, without occlusion between primitives. Nothing if a primitive with
  /// area is not flat.
  std::optional<double> projected_solid_angle_sr(const Vec3& position, const Vec3& normal,
                                                 bool two_sided) const;
  /// Whether a part of it may occlude another.  False if all of it is in one plane, to within the
  /// rounding of its corners.  Tests each primitive.
  bool hides_itself() const;

  /// Density of points chosen by area: 1 / area for triangles, sample_area's density for patches.
  AreaPdf pdf_area(const SurfacePoint& point) const;
  /// The point of the mesh at `position`, if there is one to within rounding and `slack_m`.  It is
  /// on the nearest primitive, the first of equally near ones.  Tests each primitive.
  std::optional<SurfacePoint> locate(const Vec3& position, double slack_m = 0) const;
  /// The normal that `locate` finds at the position of `p`, on the primitive of `p`.
  Vec3 located_normal(const SurfacePoint& p, double /*slack_m*/) const {
    if constexpr (kAlwaysHasWays) {
      return p.normal;
    } else {
      const auto& patch = primitives_[p.primitive];
      return patch.normal(patch.locate(p.position));
    }
  }
  /// A cone about the mean normal: exact for flat meshes, all directions for closed ones.
  NormalCone normals() const { return normals_; }
  /// {lower, upper}
  std::pair<Vec3, Vec3> bounds() const { return bounds_; }
  /// Memory, including the vectors [bytes].
  std::size_t bytes() const;
  std::size_t size() const { return primitives_.size(); }
  const Primitive& primitive(std::size_t i) const { return primitives_[i]; }

 private:
  /// Whether every primitive has all ways of sampling: triangles do, only some patches do.
  static constexpr bool kAlwaysHasWays = std::is_same_v<Primitive, Triangle>;

  Mesh(std::vector<Primitive> primitives, std::vector<double> cumulative_area, double area_error_m2,
       std::vector<bool> rectangles, std::vector<bool> flat);
  /// Whether primitive `i` has other ways to be sampled than by area.
  bool has_ways(std::size_t i) const { return kAlwaysHasWays || rectangles_[i]; }
  bool is_flat(std::size_t i) const { return kAlwaysHasWays || flat_[i]; }
  /// The density of a primitive that is sampled by area.  It uses the receiver's height if there is
  /// one, because close to the plane the cosine to a normal loses all digits.
  double pdf_by_area(const Receiver& receiver, const SurfacePoint& point) const;

  NormalCone cone_of_normals() const;
  std::pair<Vec3, Vec3> box() const;

  std::vector<Primitive> primitives_;
  std::vector<double> cumulative_area_;  ///< running sums [m2]
  double area_error_m2_;
  /// For each patch, whether it is a rectangle, and whether it is flat; empty for triangles.
  std::vector<bool> rectangles_, flat_;
  NormalCone normals_;
  std::pair<Vec3, Vec3> bounds_;
};

using TriangleMesh = Mesh<Triangle>;
using PatchMesh = Mesh<BilinearPatch>;

extern template class Mesh<Triangle>;
extern template class Mesh<BilinearPatch>;

}  // namespace lucerna
