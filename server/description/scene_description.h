// What a scene file says, before anything is built from it: shapes, materials, lights and a camera
// in world space, double precision.  Loaders fill it, the scene compiler consumes it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "lights/maths/motion.h"
#include "lights/maths/transform.h"
#include "lights/models/beam_light.h"
#include "lights/models/distant_light.h"
#include "lights/models/goniometric_light.h"
#include "lights/models/image_infinite_light.h"
#include "lights/models/infinite_light.h"
#include "lights/models/panel.h"
#include "lights/models/point_light.h"
#include "lights/models/portal_light.h"
#include "lights/models/projection_light.h"
#include "lights/models/spot_light.h"
#include "lights/models/sun_light.h"
#include "lights/shapes/cylinder.h"
#include "lights/shapes/disk.h"
#include "lights/shapes/picture.h"
#include "lights/shapes/sphere.h"
#include "lights/spectra/spectrum.h"
#include "server/assets/asset.h"

namespace lucerna {

/// Where a file says something.  `file` is relative to the scene root.
struct SourceLocation {
  std::string file;
  int line = 0;    ///< from 1; 0: the file as a whole
  int column = 0;  ///< from 1
};

/// Something that a file asks for and that is not modelled, and what was done instead.
struct Remark {
  SourceLocation where;
  std::string what;     ///< "material \"conductor\" is not modelled"
  std::string instead;  ///< "diffuse, reflectance 0.5"
};

struct DiffuseMaterial {
  Rgb<double> reflectance{0.5};  ///< each channel in [0, 1]
};

/// A triangle mesh in world space (object space within an ObjectDefinition).  Winding is resolved:
/// cross(p1 - p0, p2 - p0) is the outside, whatever ReverseOrientation, mirrors and vertex normals
/// said.
struct TriangleMeshData {
  std::vector<Vec3<double>> positions;
  std::vector<Vec3<float>> normals;    ///< shading normals, unit, per vertex; empty: flat
  std::vector<std::uint32_t> indices;  ///< three a triangle, all < positions.size()
  /// Where an emission image lies: (u, v) of each triangle's corners; empty where there is none.
  std::vector<Vec2<float>> corner_uv{};
};

/// Bilinear patches, four corners each: (0,0), (1,0), (0,1), (1,1).  cross(dp/du, dp/dv) is the
/// outside.
struct PatchMeshData {
  std::vector<Vec3<double>> positions;
  std::vector<Vec3<float>> normals;    ///< shading normals, unit, per vertex; empty: geometric
  std::vector<std::uint32_t> indices;  ///< four a patch
  /// As a triangle mesh has it; empty also where each patch shows the whole image.
  std::vector<Vec2<float>> corner_uv{};
};

struct ShapeDescription {
  std::variant<TriangleMeshData, PatchMeshData, SphereParams, DiskParams, CylinderParams> geometry;
  std::uint32_t material = 0;  ///< index into SceneDescription::materials
  /// Set where the shape is an area light; exact level, `scale` and `power` already applied.
  struct Emission {
    Rgb<double> radiance_cd_m2;
    bool two_sided = false;
    SourceLocation where;
    std::shared_ptr<const Spectrum> spectrum{};  ///< null where it was given RGB
    std::optional<Picture> picture{};            ///< what `radiance_cd_m2` is multiplied with
    std::optional<PanelProfile> panel{};         ///< what `radiance_cd_m2` multiplies
    std::uint32_t samples = 1;                   ///< as SceneLight has it
  };
  std::optional<Emission> emission{};
  SourceLocation where{};
  /// World to world, where it moves: `geometry` is that of the first key frame.  Not within an
  /// ObjectDefinition.
  std::shared_ptr<const Motion> motion{};
};

/// A named object; its shapes are in object space and carry no emission.
struct ObjectDefinition {
  std::string name;
  std::vector<ShapeDescription> shapes;
};

struct InstanceDescription {
  std::uint32_t object = 0;  ///< index into SceneDescription::objects
  Transform world_from_object;
  std::shared_ptr<const Motion> motion{};  ///< as in ShapeDescription
  SourceLocation where{};
};

/// A light that is no shape.
struct LightDescription {
  std::variant<PointLightParams, SpotLightParams, DistantLightParams, SunLightParams,
               UniformInfiniteLightParams, ImageInfiniteLightParams, GoniometricLightParams,
               ProjectionLightParams, BeamLightParams, PortalLightParams>
      params;
  SourceLocation where;
  std::shared_ptr<const Spectrum> spectrum{};  ///< null where it was given RGB
  /// World to world, where it moves: `params` then are those of the first key frame.
  std::shared_ptr<const Motion> motion{};
  std::uint32_t samples = 1;  ///< as SceneLight has it
};

/// A pinhole camera.  Camera space is left-handed: +x right, +y up, +z forward.
struct PerspectiveCamera {
  Transform world_from_camera;
  /// The image plane at z = 1: x from screen_min.x (left) to screen_max.x, y from screen_min.y
  /// (bottom) to screen_max.y, tangents of the half angles.
  Vec2<double> screen_min{-1, -1}, screen_max{1, 1};
  /// World to world, where it moves: `world_from_camera` then is that of the first key frame.
  std::shared_ptr<const Motion> motion{};
};

struct Film {
  int width = 1280;  ///< pixels, after any crop is ignored
  int height = 720;
  double scale =
      1;  ///< what pixel values are multiplied by (the film's sensor), 1: linear radiance
};

/// Read as hints: defaults for requests that do not say.
struct RenderHints {
  std::optional<int> max_depth;  ///< path length, 1 is direct light only (pbrt's maxdepth)
  std::optional<int> samples_per_pixel;
  double shutter_open_s = 0;   ///< what moves is blurred over the time between
  double shutter_close_s = 0;  ///< not before shutter_open_s
};

struct SceneDescription {
  std::vector<DiffuseMaterial> materials;
  std::vector<ShapeDescription> shapes;
  std::vector<ObjectDefinition> objects;
  std::vector<InstanceDescription> instances;
  std::vector<LightDescription> lights;  ///< in file order; area lights are in `shapes`
  PerspectiveCamera camera;
  Film film;
  RenderHints hints;
  std::vector<Remark> remarks;
  std::vector<Asset> assets;  ///< in the order in which they were first read
};

}  // namespace lucerna
