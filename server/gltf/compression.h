// Unpacks compressed geometry.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/gltf/view.h"

namespace lucerna::gltf {

/// The bytes of a buffer view with EXT_meshopt_compression.  `packed` is the extension.
std::string unpack_meshopt(const View& packed, std::string_view bytes);

/// A primitive with KHR_draco_mesh_compression.
struct DracoMesh {
  std::vector<std::uint32_t> indices;  ///< three per triangle
  std::size_t points = 0;
  /// By attribute: its values, `components` for each point.
  struct Attribute {
    std::size_t components = 0;
    std::vector<double> values;
  };
  std::map<std::string, Attribute> attributes;
};

/// Unpacks the attributes that `packed` (the extension) names.
DracoMesh unpack_draco(const View& packed, std::string_view bytes);

}  // namespace lucerna::gltf
