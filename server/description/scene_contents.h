// What a scene holds: counts by kind, for people.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/description/scene_description.h"

namespace lucerna {

/// The things of one kind.
struct KindCount {
  std::string kind;  ///< "triangle mesh", "conductor", "imagemap"
  std::uint64_t count = 0;
  std::uint64_t primitives = 0;    ///< of shapes; else 0
  std::uint64_t without_area = 0;  ///< of the primitives: triangles and patches without area
};

/// A picture of textures.
struct TexturePicture {
  std::string name;  ///< as the scene file names it; empty if it does not
  int width = 0, height = 0;
  std::uint64_t bytes = 0;  ///< in memory
};

/// Only kinds that the scene has.
struct SceneContents {
  std::vector<KindCount> shapes;  ///< shapes of an object once, for any number of instances
  std::uint64_t objects = 0, instances = 0;
  std::vector<KindCount> materials;  ///< that shapes use
  std::vector<KindCount> textures;
  std::vector<TexturePicture> pictures;  ///< each once
  std::string camera;                    ///< "perspective", "orthographic with a lens"
};

/// The triangles, patches, curves or other primitives of a shape.
std::uint64_t primitives_of(const ShapeDescription& shape);

/// Requires indices in range.
SceneContents contents_of(const SceneDescription& scene);

}  // namespace lucerna
