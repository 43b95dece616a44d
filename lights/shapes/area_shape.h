// The members that every shape of an area light has, as a concept, and the list of all shapes.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <concepts>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include "lights/maths/normal_cone.h"
#include "lights/shapes/cylinder.h"
#include "lights/shapes/disk.h"
#include "lights/shapes/mesh.h"
#include "lights/shapes/shape.h"
#include "lights/shapes/sphere.h"

/// `X(Shape)` for each shape of this library.  This list defines the area lights, the shapes with
/// pictures and their names in the list of all lights.
#define LUCERNA_AREA_SHAPES(X) X(TriangleMesh) X(PatchMesh) LUCERNA_QUADRICS(X)
/// Shapes that can be flat.  This list defines the panels.
#define LUCERNA_FLAT_SHAPES(X) X(TriangleMesh) X(PatchMesh) LUCERNA_FLAT_QUADRICS(X)
/// Shapes that are one surface with parameters.  This list defines how a scene describes, hits and
/// counts them.  The next two lists name the flat ones and the curved ones again.
#define LUCERNA_QUADRICS(X) X(Sphere) X(Disk) X(Cylinder)
#define LUCERNA_FLAT_QUADRICS(X) X(Disk)
#define LUCERNA_CURVED_QUADRICS(X) X(Sphere) X(Cylinder)

namespace lucerna {

/// Shapes whose projected solid angle at a receiver has a closed form.
template <typename Shape>
concept HasProjectedSolidAngle = requires(const Shape& shape, const Vec3& p, const Vec3& n) {
  { shape.projected_solid_angle_sr(p, n, true) } -> std::same_as<std::optional<double>>;
  { shape.hides_itself() } -> std::same_as<bool>;
};

/// The members that every shape of an area light has:
/// - `area`, `area_error_m2`: the area and a bound on its error, 0 where it is exact [m2].
/// - `emissive_error`: OK where the shape can carry a light.
/// - `sample(receiver, u)`, `pdf(receiver, point)`: points seen from a receiver, and their density.
/// - `for_each_hit(position, wi, f)`: calls `f` with each point of the shape along `wi`.
/// - `touches(position, primitive)`: whether a position lies on a primitive.
/// - `height_over(point, position)`: how far a position is above the plane of a flat primitive.
///   None for curved shapes.
/// - `height_above(p, n)`: a bound on the height of its points over the plane through `p` with the
///   unit normal `n`.
/// - `pdf_area(point)`, `locate(position, slack)`, `located_normal(point, slack)`: for rays that
///   leave the shape.
/// - `normals`, `bounds`: a cone with all normals, and a box.
/// - `size`: how many primitives it has.
/// - `bytes`: its memory.
/// - `kHasProjectedSolidAngle`: whether it has `projected_solid_angle_sr` and `hides_itself`.
template <typename Shape>
concept AreaShape = requires(const Shape& shape, const Receiver& receiver,
                             const SurfacePoint& point, const Vec3& v, const Vec3& p, const Vec2& u,
                             void (&f)(const SurfacePoint&)) {
  { shape.area() } -> std::same_as<double>;
  { shape.area_error_m2() } -> std::same_as<double>;
  { shape.emissive_error() } -> std::same_as<absl::Status>;
  { shape.sample(receiver, u) } -> std::same_as<ShapeSample>;
  { shape.pdf(receiver, point) } -> std::same_as<SolidAnglePdf>;
  shape.for_each_hit(v, v, f);
  { shape.touches(v, 0) } -> std::same_as<bool>;
  { shape.height_over(point, v) } -> std::same_as<std::optional<double>>;
  { shape.height_above(p, p) } -> std::same_as<double>;
  { shape.pdf_area(point) } -> std::same_as<AreaPdf>;
  { shape.locate(v, 0.0) } -> std::same_as<std::optional<SurfacePoint>>;
  { shape.located_normal(point, 0.0) } -> std::same_as<Vec3>;
  { shape.normals() } -> std::same_as<NormalCone>;
  { shape.bounds() } -> std::same_as<std::pair<Vec3, Vec3>>;
  { shape.size() } -> std::same_as<std::size_t>;
  { shape.bytes() } -> std::same_as<std::size_t>;
  requires Shape::kHasProjectedSolidAngle == HasProjectedSolidAngle<Shape>;
};

/// The further members of a shape that is one surface with parameters:
/// - `Params`, `create(params, origin)`: its parameters, and the surface or the field that is out
///   of its domain.
/// - `kName`: its name in messages.
/// - `intersect(origin, direction, t_min, t_max)`: the first point along a ray.
/// - `enclosure()`: a convex body that contains it.
template <typename Shape>
concept QuadricShape = AreaShape<Shape> &&
    requires(const Shape& shape, const typename Shape::Params& params, const Vec3& v) {
  { Shape::create(params, v) } -> std::same_as<absl::StatusOr<Shape>>;
  { Shape::kName } -> std::convertible_to<std::string_view>;
  { shape.intersect(v, v, 0.0, 1.0) } -> std::same_as<std::optional<ShapeHit>>;
  { shape.enclosure() } -> std::same_as<RoundEnclosure>;
};
#define LUCERNA_QUADRIC(Shape) static_assert(QuadricShape<Shape>);
LUCERNA_QUADRICS(LUCERNA_QUADRIC)
#undef LUCERNA_QUADRIC

/// Quadrics that lie in a plane.
template <typename Shape>
concept IsFlat = requires(const Shape& shape, const Vec3& p) {
  shape.height_of(p);
};
#define LUCERNA_FLAT(Shape) static_assert(IsFlat<Shape>);
#define LUCERNA_CURVED(Shape) static_assert(!IsFlat<Shape>);
LUCERNA_FLAT_QUADRICS(LUCERNA_FLAT)
LUCERNA_CURVED_QUADRICS(LUCERNA_CURVED)
#undef LUCERNA_FLAT
#undef LUCERNA_CURVED

template <typename Params>
struct QuadricOfParams;
#define LUCERNA_QUADRIC(Shape)            \
  template <>                             \
  struct QuadricOfParams<Shape##Params> { \
    using type = Shape;                   \
  };
LUCERNA_QUADRICS(LUCERNA_QUADRIC)
#undef LUCERNA_QUADRIC
/// The shape that is made from `Params`.
template <typename Params>
using QuadricOf = typename QuadricOfParams<Params>::type;

}  // namespace lucerna
