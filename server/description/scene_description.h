// The contents of a scene file before anything is built from it: shapes, materials, lights and a
// camera in world space, in double precision.  Loaders fill it; the scene builder consumes it.
#pragma once

#include <array>
#include <boost/container/deque.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "lights/maths/motion.h"
#include "lights/maths/spectrum.h"
#include "lights/maths/transform.h"
#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "server/description/boxed.h"
#include "server/description/pixel_filter.h"
#include "server/description/source_location.h"
#include "server/files/asset.h"
#include "server/files/load_limits.h"
#include "server/materials/material.h"

namespace lucerna {

/// Parts of files that are not modelled, and what happens instead.  Equal parts are one remark.
struct Remark {
  SourceLocation where;                ///< the first place
  std::string what;                    ///< "material \"conductor\" is not modelled"
  std::string instead;                 ///< "diffuse, reflectance 0.5"
  std::uint64_t count = 1;             ///< of all its places
  std::vector<SourceLocation> more{};  ///< the next places, a few of them
};

/// A medium that absorbs light and does not scatter it.  After d metres, exp(-absorption d) of each
/// channel is left.
struct Medium {
  Rgb absorption_per_m;  ///< at least 0
};

/// The media on both sides of a surface: indices into SceneDescription::media, -1 for none.
struct MediumSides {
  std::int32_t inside = -1;   ///< where the normal points away from
  std::int32_t outside = -1;  ///< where the normal points to
};

/// The direction in which u grows, unit or zero, and that of v: cross(normal, along_u) times
/// `turn`, which is 1 or -1.
struct VertexTangent {
  Vec3f along_u;
  float turn = 1;
};

/// A triangle mesh in world space (object space within an ObjectDefinition).  cross(p1 - p0, p2 -
/// p0) points to the outside.  The loader sets this winding from ReverseOrientation, mirrors and
/// vertex normals.
struct TriangleMeshData {
  std::vector<Vec3> positions;
  std::vector<Vec3f> normals;          ///< shading normals, unit, one for each vertex; empty: flat
  std::vector<std::uint32_t> indices;  ///< three per triangle, all < positions.size()
  /// (u, v) of each triangle's corners, for an emission image or textures; empty if there is none.
  std::vector<Vec2f> corner_uv{};
  /// For VertexColourTexture, one for each vertex; empty if there is none.
  std::vector<Rgbf> colours{};
  /// For materials with FrameAlong::kV, one for each vertex; empty: from (u, v).
  std::vector<VertexTangent> tangents{};
};

/// Bilinear patches with four corners each: (0,0), (1,0), (0,1), (1,1).  cross(dp/du, dp/dv) points
/// to the outside.
struct PatchMeshData {
  std::vector<Vec3> positions;
  std::vector<Vec3f> normals;          ///< shading normals, unit, per vertex; empty: geometric
  std::vector<std::uint32_t> indices;  ///< four per patch
  /// The same as for triangles; also empty if each patch shows the whole image.
  std::vector<Vec2f> corner_uv{};
};

/// What rays meet along a curve (server/rays/curve.h).
enum class CurveKind : std::uint8_t { kFlat, kCylinder, kRibbon };

/// Curves that join, from their control points.  Their width changes evenly from the first to the
/// last.  They do not emit.
struct CurveData {
  CurveKind kind{};
  std::vector<Vec3> points{};
  int degree = 3;                             ///< 2 or 3
  bool is_b_spline = false;                   ///< with even knots; else Bezier curves
  double start_width_m = 1, end_width_m = 1;  ///< at least 0
  std::vector<Vec3> normals{};                ///< of a ribbon: unit, count() + 1; else empty

  /// Requires as many points as check_curves() allows (server/description/curve_pieces.h).
  std::size_t count() const {
    const auto d = static_cast<std::size_t>(degree);
    return is_b_spline ? points.size() - d : (points.size() - 1) / d;
  }
};

namespace internal {
template <typename... Shapes>
std::variant<TriangleMeshData, PatchMeshData, CurveData, typename Shapes::Params...> geometry_of(
    ShapeTypes<Shapes...>);
}  // namespace internal

/// The parameters of any shape.
using Geometry = decltype(internal::geometry_of(Quadrics()));

struct ShapeDescription {
  Geometry geometry;
  std::uint32_t material = 0;  ///< index into SceneDescription::materials
  bool has_uv = false;         ///< whether textures use the (u, v) of its surface
  /// The share of rays that meet the surface; the others pass it.  The radiance of a surface that
  /// emits is multiplied by it.
  NumberValue alpha{1};
  /// Set if the media on its sides differ.
  std::optional<MediumSides> media{};
  /// Whether rays do not meet the surface: it only bounds media.  It does not emit, and `material`
  /// has no effect.
  bool is_interface = false;
  /// Set if the shape is an area light.  The level is final: `scale` and `power` are applied.
  struct Emission {
    Rgb radiance_cd_m2;
    bool two_sided = false;
    SourceLocation where;
    std::shared_ptr<const Spectrum> spectrum{};  ///< null for a light given in RGB
    std::optional<Picture> picture{};            ///< multiplies `radiance_cd_m2`
    std::optional<PanelProfile> panel{};         ///< `radiance_cd_m2` multiplies its radiance
    std::uint32_t samples = 1;                   ///< the same as in SceneLight
    std::string name{};                          ///< the same as in LightDescription
    /// Whether rays do not meet the surface, so that only samples of the light find it.
    bool is_unseen = false;
  };
  Boxed<Emission> emission{};
  SourceLocation where{};
  /// Motion in the world; null if it does not move.  `geometry` is at the first key frame.  Not
  /// used within an ObjectDefinition.
  std::shared_ptr<const Motion> motion{};
};

/// A list that may have millions of elements.  A vector holds its elements twice while it grows. An
/// empty std::deque takes half a kilobyte.
template <typename T>
using LongList = boost::container::deque<T>;

using ShapeList = LongList<ShapeDescription>;

/// A named object.  Its shapes are in object space and do not emit.
struct ObjectDefinition {
  std::string name;
  ShapeList shapes;
};

struct InstanceDescription {
  std::uint32_t object = 0;  ///< index into SceneDescription::objects
  Transform world_from_object;
  std::shared_ptr<const Motion> motion{};  ///< the same as in ShapeDescription
  SourceLocation where{};
};

/// A light that is not a shape.
struct LightDescription {
  LightParams params;
  SourceLocation where;
  std::shared_ptr<const Spectrum> spectrum{};  ///< null for a light given in RGB
  /// Motion in the world; null if it does not move.  `params` are at the first key frame.
  std::shared_ptr<const Motion> motion{};
  std::uint32_t samples = 1;  ///< the same as in SceneLight
  std::string name{};         ///< a light name (server/files/printable.h); empty: none
};

/// How a camera maps film positions to rays.  [Pharr23, 5]
enum class Projection : std::uint8_t {
  kPerspective,
  kOrthographic,
  kEqualArea,        ///< all directions; +y in the middle, -y at the corners, +x right, +z below
  kEquirectangular,  ///< all directions; +y at the top, +z at a quarter of the width
};

/// Camera space is left-handed: +x right, +y up, +z forward.
struct CameraDescription {
  Transform world_from_camera;
  Projection projection = Projection::kPerspective;
  /// x from screen_min.x (left) to screen_max.x, y from screen_min.y (bottom) to screen_max.y.
  /// Perspective: on the plane z = 1, tangents of half angles.  Orthographic: on the plane z = 0,
  /// in units of camera space.  Not used by the other two.
  Vec2 screen_min{-1, -1}, screen_max{1, 1};
  /// Of a thin lens around the camera's position, in units of camera space; 0: a pinhole.  In
  /// [0, 1e6].  Not used by cameras that see all directions.
  double lens_radius = 0;
  double focal_distance = 1e6;  ///< z of the plane in focus, in [1e-6, 1e30]
  /// Motion in the world; null if it does not move.  `world_from_camera` is at the first key frame.
  std::shared_ptr<const Motion> motion{};
};

/// A rectangle of the film's pixels: x0 <= x < x1, y0 <= y < y1, not empty.
struct FilmCrop {
  int x0, y0, x1, y1;
};

struct Film {
  int width = 1280;  ///< pixels, without a crop
  int height = 720;
  double scale = 1;  ///< factor of pixel values (the film's sensor); 1: linear radiance
  std::optional<FilmCrop> crop{};               ///< the picture; unset: the whole film
  std::shared_ptr<const PixelFilter> filter{};  ///< null: a box of one pixel
};

/// Defaults for requests that do not set these values.
struct RenderHints {
  std::optional<int> max_depth;  ///< path length, 1 is direct light only (pbrt's maxdepth)
  std::optional<int> samples_per_pixel;
  double shutter_open_s = 0;   ///< motion is blurred from here to shutter_close_s
  double shutter_close_s = 0;  ///< not before shutter_open_s
};

/// Factors of the light levels that a file states.
struct LevelFactors {
  double lamps = 1;     ///< of point lights and spots
  double suns = 1;      ///< of distant lights
  double emission = 1;  ///< of surfaces that emit and of pictures of the sky

  bool operator==(const LevelFactors&) const = default;
};

struct SceneDescription {
  std::deque<Material> materials;  // GCC 12 warns falsely about a LongList of these
  Textures textures;
  std::vector<Medium> media;
  std::int32_t surrounding_medium = -1;  ///< where no surface bounds a medium; -1 for none
  ShapeList shapes;
  LongList<ObjectDefinition> objects;
  LongList<InstanceDescription> instances;
  LongList<LightDescription> lights;  ///< in file order; area lights are in `shapes`
  CameraDescription camera;
  Film film;
  RenderHints hints;
  LevelFactors level_factors;  ///< applied to all lights of the description
  std::vector<Remark> remarks;
  std::vector<Asset> assets;  ///< in the order of their first use
  /// What the budget of the load counts for the arrays above, until the scene is built from them.
  std::uint64_t held_bytes = 0;
};

}  // namespace lucerna
