// The list of all shapes.  This is the one place that names them.
#pragma once

#include <absl/status/statusor.h>

#include <concepts>
#include <cstddef>
#include <optional>
#include <string_view>
#include <type_traits>

#include "lights/shapes/cylinder.h"
#include "lights/shapes/disk.h"
#include "lights/shapes/mesh.h"
#include "lights/shapes/shape.h"
#include "lights/shapes/sphere.h"

namespace lucerna {

/// A list of types.
template <typename... Shapes>
struct ShapeTypes {
  /// Calls `f.operator()<Shape>()` for each.
  template <typename F>
  static constexpr void for_each(F&& f) {
    (f.template operator()<Shapes>(), ...);
  }
};

/// The shapes that are one surface with parameters.  How a scene describes, hits, bounds and counts
/// them follows from this list.
using Quadrics = ShapeTypes<Sphere, Disk, Cylinder>;

/// Their members beside those of Shape:
/// - `Params`, `create(params, origin)`: its parameters, and the surface or the field that is out
///   of its domain.
/// - `kName`: its name in messages.
/// - `intersect(origin, direction, t_min, t_max)`: the first point along a ray.
/// - `enclosure()`: a convex body that contains it.
template <typename S>
concept QuadricShape = std::derived_from<S, Shape> &&
    requires(const S& shape, const typename S::Params& params, const Vec3& v) {
  { S::create(params, v) } -> std::same_as<absl::StatusOr<S>>;
  { S::kName } -> std::convertible_to<std::string_view>;
  { shape.intersect(v, v, 0.0, 1.0) } -> std::same_as<std::optional<ShapeHit>>;
  { shape.enclosure() } -> std::same_as<RoundEnclosure>;
};

/// Quadrics that lie in a plane.
template <typename S>
concept FlatShape = requires(const S& shape, const Vec3& p) {
  shape.height_of(p);
};

namespace internal {
template <typename Params, typename List>
struct QuadricOf;
template <typename Params, typename S, typename... Rest>
struct QuadricOf<Params, ShapeTypes<S, Rest...>>
    : std::conditional_t<std::is_same_v<typename S::Params, Params>, std::type_identity<S>,
                         QuadricOf<Params, ShapeTypes<Rest...>>> {};
template <typename Params>
struct QuadricOf<Params, ShapeTypes<>> {};
}  // namespace internal

/// The shape that is made from `Params`.
template <typename Params>
using QuadricOf = typename internal::QuadricOf<Params, Quadrics>::type;

/// Calls `f` with the shape as its own type.
template <typename F>
void visit_shape(const Shape& shape, F&& f) {
  const auto visit = [&]<typename... Shapes>(ShapeTypes<Shapes...>) {
    const auto as = [&]<typename S>(const S* own) { return own != nullptr && (f(*own), true); };
    (as(dynamic_cast<const Shapes*>(&shape)) || ...);
  };
  visit(ShapeTypes<TriangleMesh, PatchMesh>());
  visit(Quadrics());
}

}  // namespace lucerna
