// The members that spheres, disks and cylinders share.  They are quadrics around the z axis of
// object space, swept about it and placed by an affine map.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "lights/maths/normal_cone.h"
#include "lights/maths/transform.h"
#include "lights/shapes/round_shape.h"

namespace lucerna {

/// InvalidArgument for one field of a shape's parameters.
inline absl::Status refuse_field(std::string_view shape, std::string_view field, double value,
                                 std::string_view allowed) {
  return absl::InvalidArgumentError(
      fmt::format("{}.{} = {}, allowed {}", shape, field, value, allowed));
}

/// The checks of the fields that all quadrics have.
template <typename Params>
absl::Status check_radius(std::string_view shape, const Params& p) {
  if (!(p.radius_m > 0) || !std::isfinite(p.radius_m))
    return refuse_field(shape, "radius_m", p.radius_m, "finite and > 0");
  return absl::OkStatus();
}
template <typename Params>
absl::Status check_sweep(std::string_view shape, const Params& p) {
  if (!(p.phi_max_rad > 0 && p.phi_max_rad <= kTurnRad))
    return refuse_field(shape, "phi_max_rad", p.phi_max_rad, "(0, 2 pi]");
  return absl::OkStatus();
}

/// Where a ray meets a quadric, in object space.
struct QuadricRoot {
  double t;  ///< along the ray, in units of its direction
  Vec3 p;    ///< on the surface
};
using QuadricRoots = std::array<QuadricRoot, 2>;

/// A convex body around a shape: the centre and half-axes of an ellipsoid or an ellipse in world
/// space about the origin [m].  For a prism the last axis is that of the prism.
struct RoundEnclosure {
  Vec3 center, x, y, z;
  bool is_prism;
};

/// `Self` derives from this class and has the private members
/// - `roots(origin, direction, t_min, t_max, out)`: finds where a world ray meets the surface with
///   t in (t_min, t_max), by increasing t.  Returns the number of roots.
/// - `nearest(q)`: the point nearest to `q` on the surface with a full sweep, object space. None if
///   `q` has no nearest point.
/// - `normal_at(p)`: the world normal at a point of the surface.
/// and the public member `bounds`.
template <typename Self, typename ShapeParams>
class Quadric : public RoundShape {
 public:
  using Params = ShapeParams;

  /// 0 if `emissive_error` does not allow the map.
  double area() const override { return area_m2_; }
  double area_error_m2() const override { return 0; }
  std::size_t size() const override { return 1; }
  std::size_t bytes() const override { return sizeof(Self); }

  /// First hit with t in (t_min, t_max), `direction` of any length.  Rays pass through the part
  /// that is cut away.  The hit is moved onto the surface, which removes rounding.
  std::optional<ShapeHit> intersect(const Vec3& origin, const Vec3& direction, double t_min,
                                    double t_max) const {
    QuadricRoots root;
    if (self().roots(origin, direction, t_min, t_max, root) == 0) return std::nullopt;
    return ShapeHit{root[0].t, surface_point(root[0].p)};
  }
  /// All hits with t in (t_min, t_max).
  ShapeHits hits(const Vec3& origin, const Vec3& direction, double t_min, double t_max) const {
    ShapeHits found;
    QuadricRoots root;
    const int count = self().roots(origin, direction, t_min, t_max, root);
    for (int i = 0; i < count; ++i) found.add(root[i].t, surface_point(root[i].p));
    return found;
  }
  void for_each_hit(const Vec3& receiver, const Vec3& wi,
                    absl::FunctionRef<void(const SurfacePoint&)> f) const override {
    const auto found = hits(receiver, wi, 0, std::numeric_limits<double>::infinity());
    for (int i = 0; i < found.count; ++i) f(found.hit[i].point);
  }

  AreaPdf pdf_area(const SurfacePoint&) const override { return {1 / area_m2_}; }
  std::optional<SurfacePoint> locate(const Vec3& position, double slack_m = 0) const override {
    std::optional<Vec3> q = self().nearest(object_from_world_.point(position));
    if (!q) return std::nullopt;
    q = nearest_swept(*q, params_.phi_max_rad);
    const Vec3 nearest = world_from_object_.point(*q);
    if (!(length(nearest - position) <= rounding_m(self().bounds()) + slack_m)) return std::nullopt;
    return SurfacePoint{position, self().normal_at(*q)};
  }
  Vec3 located_normal(const SurfacePoint& p, double slack_m) const override {
    const auto found = locate(p.position, slack_m);
    return found ? found->normal : p.normal;
  }

  /// The height of the enclosure.
  double height_above(const Vec3& p, const Vec3& n) const override {
    const RoundEnclosure e = self().enclosure();
    const double x = dot(e.x, n), y = dot(e.y, n), z = dot(e.z, n);
    return dot(e.center - p, n) +
           (e.is_prism ? std::hypot(x, y) + std::fabs(z) : std::hypot(x, y, z));
  }

  const ShapeParams& params() const { return params_; }
  /// World coordinates are relative to the `origin_m` of `create`.
  const Transform& world_from_object() const { return world_from_object_; }

 protected:
  Quadric(const ShapeParams& params, const Vec3& origin_m)
      : params_(params),
        world_from_object_(params.world_from_object.about(origin_m)),
        object_from_world_(world_from_object_.inverse()) {}

  /// `shape` if its bounds fit `double`.  Else InvalidArgument with the world position of `what`,
  /// such as "the disk", which is `at` in object space.
  static absl::StatusOr<Self> with_finite_bounds(Self shape, std::string_view name,
                                                 std::string_view what, const Vec3& at) {
    const auto [lower, upper] = shape.bounds();
    if (is_finite(lower) && is_finite(upper)) return shape;
    const Vec3 p = shape.world_from_object_.point(at);
    return absl::InvalidArgumentError(
        fmt::format("{}.world_from_object puts {} about ({}, {}, {}), "
                    "allowed: finite bounds, in {} bits",
                    name, what, p.x, p.y, p.z, 8 * sizeof(double)));
  }

  /// InvalidArgument for a map that an emissive shape must not have.
  absl::Status refuse_map(std::string_view name, std::string_view allowed) const {
    const auto& m = params_.world_from_object.matrix();
    const auto factor = [&m](int column) {
      return length(Vec3{m[0][column], m[1][column], m[2][column]});
    };
    return absl::InvalidArgumentError(fmt::format(
        "{}.world_from_object scales x, y, z by ({}, {}, {}), allowed for an emissive {}: {}", name,
        factor(0), factor(1), factor(2), name, allowed));
  }

  /// The point of radius `r` about the axis at height `z` and angle `phi`.
  static Vec3 on_ring(double r, double phi, double z) {
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  /// The world point of a surface point in object space.
  SurfacePoint surface_point(const Vec3& p) const {
    return {world_from_object_.point(p), self().normal_at(p)};
  }
  /// A world normal from an object space vector along the outward normal.
  Vec3 oriented(const Vec3& outward) const {
    const Vec3 n = normalized(world_from_object_.normal(outward));
    return params_.reverse_orientation ? -n : n;
  }
  /// The density of points chosen uniformly by area, seen from a receiver.
  SolidAnglePdf pdf_by_area(const Receiver& receiver, const SurfacePoint& point) const {
    return pdf_seen_from(receiver.position, point, AreaPdf{1 / area_m2_});
  }

  /// The two parameters at which a line meets a circle or sphere of radius `r`, the smaller first.
  /// `closest` is the middle between them, and `half_chord` is half their difference.  The origin
  /// is at `origin_distance` from the centre, and `dd` is the squared length of the direction.  The
  /// root that would cancel is computed from the other root and their product.  [Haines19]
  static std::pair<double, double> roots_of(double closest, double half_chord,
                                            double origin_distance, double r, double dd) {
    const double large = closest + std::copysign(half_chord, closest);
    const double small =
        large == 0 ? 0 : (origin_distance - r) * (origin_distance + r) / dd / large;
    return {std::min(small, large), std::max(small, large)};
  }

  ShapeParams params_;
  Transform world_from_object_, object_from_world_;  // about the scene's origin
  double area_m2_ = 0;                               // 0: the map does not preserve shares of area

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }
};

}  // namespace lucerna
