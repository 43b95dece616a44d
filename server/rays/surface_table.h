// Shading data of the primitives in a GeometrySet: material, light and normals.
#pragma once

#include <absl/status/statusor.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "lights/maths/bounds.h"
#include "server/description/scene_description.h"
#include "server/rays/accelerator.h"

namespace lucerna {

/// The data that all primitives of a shape share.
struct Surface {
  std::uint32_t material = 0;
  std::int32_t light = -1;  ///< as SceneLights::of_surface takes it; -1: does not emit
  NumberValue alpha{1};
  std::optional<NumberValue> pane_eta{};  ///< index of a smooth thin pane; else unset
  std::optional<MediumSides> media{};     ///< as in ShapeDescription
  bool is_interface = false;              ///< as in ShapeDescription

  bool is_cut_out() const { return !alpha.is_constant() || alpha.constant < 1; }
  /// Whether the same share of rays passes everywhere.
  bool is_sheet() const { return alpha.is_constant() && alpha.constant > 0 && alpha.constant < 1; }
  /// Whether some rays pass the surface.
  bool is_non_opaque() const { return is_cut_out() || pane_eta || media || is_interface; }
};

/// A ray at a surface that some rays pass.
struct RayAtSurface {
  TexturePoint at;         ///< in the space of the set
  Vec3 origin, direction;  ///< in Embree's space
  double cosine;           ///< to the normal in the scene, at least 0
};

/// The default (u, v) of a triangle's and a patch's corners.
inline constexpr std::array<Vec2f, 3> kTriangleUv{{{0, 0}, {1, 0}, {1, 1}}};
inline constexpr std::array<Vec2f, 4> kPatchUv{{{0, 0}, {1, 0}, {0, 1}, {1, 1}}};

/// Consecutive primitives of one kind that belong to one shape.
struct PrimitiveRun {
  std::uint32_t first = 0;
  std::uint32_t surface = 0;
  std::uint32_t first_light_primitive =
      0;                                  ///< number of the run's first primitive within the shape
  std::uint32_t per_light_primitive = 1;  ///< 2: a flat patch stored as two triangles
  /// Index of the (u, v) of the first primitive; kNoUv if no texture needs those of the shape.
  std::uint32_t first_uv = kNoUv;
  static constexpr std::uint32_t kNoUv = ~std::uint32_t{0};
};

struct SurfaceTable {
  std::vector<Surface> surfaces;
  /// The surfaces that are mirrors, or nearly so, at some points (SmoothTraits), with their places.
  struct SmoothSurface {
    std::uint32_t surface = 0;
    SourceLocation where{};
  };
  std::vector<SmoothSurface> smooth;
  /// By HitKind, in ascending order of `first`.
  std::array<std::vector<PrimitiveRun>, kHitKinds> runs;
  /// Shading normals, one for each vertex, zero without one.  Empty if no mesh has any.
  std::vector<Vec3f> vertex_normals;
  /// Shading normals at the corners of each patch.  Empty if no patch has any.
  std::vector<std::array<Vec3f, 4>> patch_normals;

  /// Colours and tangents of each vertex, up to the last mesh that has them.  Black and zero
  /// without them.
  std::vector<Rgbf> vertex_colours;
  std::vector<VertexTangent> vertex_tangents;

  /// (u, v) at the corners of triangles and of patches, for the runs with a `first_uv`.
  std::vector<std::array<Vec2f, 3>> triangle_uv;
  std::vector<std::array<Vec2f, 4>> patch_uv;

  /// Where the values of alpha textures are; null if all are opaque.
  const Textures* textures = nullptr;
  /// World position of the zero of the set's coordinates, for textures of non-opaque surfaces.  For
  /// objects it is in the space of their definition, where pbrt-v4 evaluates alpha too.
  Vec3 origin_m{};

  const PrimitiveRun& run(HitKind kind, std::uint32_t primitive) const;
  std::size_t bytes() const;
  bool has_non_opaque() const;
  /// (u, v) at the corners; those of kTriangleUv and kPatchUv if they are not stored.
  const std::array<Vec2f, 3>& uv_of_triangle(std::uint32_t triangle) const;
  const std::array<Vec2f, 4>& uv_of_patch(std::uint32_t patch) const;
  /// (u, v) of a triangle at these barycentric coordinates, and of a patch at its parameters.
  Vec2 triangle_uv_at(std::uint32_t triangle, double b, double c) const;
  Vec2 patch_uv_at(std::uint32_t patch, double s, double t) const;
  /// Whether a ray that meets only `meets` passes through the surface at a hit.  Where chance
  /// decides, the bits of the ray and of the hit choose, so that a ray has one answer.
  bool lets_pass(HitKind kind, std::uint32_t primitive, RayFilter filter,
                 const RayAtSurface& ray) const;
};

/// Bounds of a shape in its own space.  Errors: values that are not finite or out of their
/// domain.
absl::StatusOr<Bounds> shape_bounds(const ShapeDescription& shape);

/// A position as floats about an origin, as in Embree's geometry.
inline Vec3f about(const Vec3& position, const Vec3& origin) { return Vec3f(position - origin); }

/// Whether four corners (in patch order) form a convex quadrangle that is flat to within the
/// rounding of its coordinates.  Two triangles are then the same surface, and faster to hit.
bool is_flat_and_convex(const std::array<Vec3, 4>& corners);

/// Adds one shape to `set` and `table`, with positions about `origin`.  Triangles that Embree finds
/// with an error of more than a thousandth of `detail_m` become large, up to 4096 in a set.
absl::Status append_shape(const ShapeDescription& shape, const Vec3& origin, double detail_m,
                          std::int32_t light, GeometrySet& set, SurfaceTable& table);

}  // namespace lucerna
