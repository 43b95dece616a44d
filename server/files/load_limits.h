// Limits on what a scene may need.  A separate file, so that programs can set them without the
// header of the scene's description.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace lucerna {

class LoadBudget;

struct LoadLimits {
  /// Memory of the pictures of surfaces; larger ones are halved.
  std::size_t texture_bytes = std::numeric_limits<std::size_t>::max();
  /// Texels of one picture.
  std::uint64_t max_texels = std::uint64_t{1} << 27;
  /// Triangles, patches, curves and other shapes of a scene; those of an object count once.
  std::uint64_t max_primitives = std::uint64_t{1} << 28;
  /// Bytes of all files of a scene together.  Compressed files also count unpacked.
  std::uint64_t max_scene_bytes = std::uint64_t{4} << 30;
  /// How deep .pbrt files may include each other.
  std::uint64_t max_include_depth = 64;
  /// Words, strings and brackets of all .pbrt files of a scene.
  std::uint64_t max_tokens = std::uint64_t{1} << 30;
  /// Counts the memory of the load; null: no limit.
  LoadBudget* budget = nullptr;
};

}  // namespace lucerna
