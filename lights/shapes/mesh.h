// Meshes as the shape of an area light: primitives chosen by area, then sampled as the receiver
// asks.
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

/// `Primitive<Real>` is Triangle or BilinearPatch.  Winding decides the emitting side: cross of the
/// first two edges.  Primitives of zero area are kept (their numbers are the caller's) and never
/// sampled.  Immutable, so safe to share between threads.
template <typename Real, template <typename> typename Primitive>
class Mesh {
 public:
  static constexpr bool kHasProjectedSolidAngle = true;

  /// Primitives already about the scene's origin.  Errors: none, not finite, no area at all.
  static absl::StatusOr<Mesh> create(std::vector<Primitive<Real>> primitives);

  /// [m2]
  double area() const { return cumulative_area_.back(); }
  /// Bound on the error of `area`, 0 where it is exact [m2].
  double area_error_m2() const { return area_error_m2_; }
  /// Always OK.
  absl::Status emissive_error() const { return absl::OkStatus(); }

  /// A primitive by its share of the area, a point of it as `receiver.area_sampling` says: a
  /// triangle or a rectangle in any way, other patches by area.  Both values of `u` choose the
  /// primitive, so that more than 2^24 of them are all reachable from floats.
  ShapeSample<Real> sample(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// A primitive by its share of the area, and u again within it.
  struct Choice {
    std::size_t index;
    Vec2<Real> u;
  };
  Choice choose(Vec2<Real> u) const;
  /// The share of the area that primitive `i` has.
  double share(std::size_t i) const {
    return (cumulative_area_[i] - (i == 0 ? 0 : cumulative_area_[i - 1])) / area();
  }
  /// The density of `sample` at a point of primitive `point.primitive`.
  SolidAnglePdf<Real> pdf(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// How far `p` is above the plane of the primitive that `point` is on, where that is flat: exact
  /// where the plane is nearly met.
  std::optional<double> height_over(const SurfacePoint<Real>& point, const Vec3<Real>& p) const {
    if (point.primitive >= primitives_.size() || !is_flat(point.primitive)) return std::nullopt;
    return primitives_[point.primitive].height_of(p);
  }

  /// Whether `p` lies on a primitive that is flat, and so sees all of it along its surface.
  bool touches(const Vec3<Real>& p, std::uint32_t primitive) const {
    return primitive < primitives_.size() && is_flat(primitive) &&
           primitives_[primitive].touches(p);
  }

  /// Calls `f(surface_point)` for every point of the mesh along the unit vector `wi`, in the order
  /// of the primitives.  Looks at each primitive: it serves the rare question for the density of a
  /// direction; rays have a BVH elsewhere.
  template <typename F>
  void for_each_hit(const Vec3<Real>& receiver, const Vec3<Real>& wi, F&& f) const {
    for (std::size_t i = 0; i < primitives_.size(); ++i) {
      auto found = primitives_[i].hits(receiver, wi, 0, std::numeric_limits<Real>::infinity());
      for (int k = 0; k < found.count; ++k) {
        found.hit[k].point.primitive = static_cast<std::uint32_t>(i);
        f(found.hit[k].point);
      }
    }
  }

  /// The projected solid angle [sr] of all sides that emit towards `position`, above the horizon of
  /// the unit vector `normal`, as if no primitive stood before another.  Nothing where one with
  /// area is not flat.
  std::optional<double> projected_solid_angle_sr(const Vec3<Real>& position,
                                                 const Vec3<double>& normal, bool two_sided) const;
  /// Whether a part of it may stand before another: false where all of it is in one plane, to
  /// within the rounding of its corners.  Looks at each primitive.
  bool hides_itself() const;

  /// Density of points by area alone: of triangles 1 / area, of patches as they share theirs out.
  AreaPdf<double> pdf_area(const SurfacePoint<Real>& point) const;
  /// The point of the mesh at `position`, where there is one to within rounding and `slack_m`: of
  /// the nearest primitive, the first of equally near ones.  Looks at each.
  std::optional<SurfacePoint<Real>> locate(const Vec3<Real>& position, double slack_m = 0) const;
  /// The normal that `locate` finds at the position of `p`, on the primitive of `p`.
  Vec3<Real> located_normal(const SurfacePoint<Real>& p) const {
    if constexpr (kAlwaysHasWays) {
      return p.normal;
    } else {
      const auto& patch = primitives_[p.primitive];
      return patch.normal(patch.locate(p.position));
    }
  }
  /// About the mean normal; exact for flat meshes, all directions for closed ones.
  NormalCone<Real> normals() const;

  /// {lower, upper}
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
  /// Memory held, with what the vectors hold [bytes].
  std::size_t bytes() const;
  std::size_t size() const { return primitives_.size(); }
  const Primitive<Real>& primitive(std::size_t i) const { return primitives_[i]; }

 private:
  /// Triangles; of patches the rectangles alone.
  static constexpr bool kAlwaysHasWays = std::is_same_v<Primitive<Real>, Triangle<Real>>;

  Mesh(std::vector<Primitive<Real>> primitives, std::vector<double> cumulative_area,
       double area_error_m2, std::vector<bool> rectangles, std::vector<bool> flat);
  /// Whether primitive `i` knows other ways to be sampled than by area.
  bool has_ways(std::size_t i) const { return kAlwaysHasWays || rectangles_[i]; }
  bool is_flat(std::size_t i) const { return kAlwaysHasWays || flat_[i]; }
  /// Of a primitive that is sampled by area: by its height where that is one, as the cosine to a
  /// normal has no digit left next to the plane.
  double pdf_by_area(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;

  std::vector<Primitive<Real>> primitives_;
  std::vector<double> cumulative_area_;  ///< running sums [m2]
  double area_error_m2_;
  /// Which of the patches are, rectangles among the flat ones; empty for triangles.
  std::vector<bool> rectangles_, flat_;
};

template <typename Real>
using TriangleMesh = Mesh<Real, Triangle>;
template <typename Real>
using PatchMesh = Mesh<Real, BilinearPatch>;

extern template class Mesh<float, Triangle>;
extern template class Mesh<double, Triangle>;
extern template class Mesh<float, BilinearPatch>;
extern template class Mesh<double, BilinearPatch>;

}  // namespace lucerna
