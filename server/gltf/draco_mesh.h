// Unpacks primitives with KHR_draco_mesh_compression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/gltf/view.h"

namespace lucerna::gltf {

/// A primitive with KHR_draco_mesh_compression.
struct DracoMesh {
  std::vector<std::uint32_t> indices;  ///< three per triangle
  /// By attribute: its values, `components` for each point.
  struct Attribute {
    std::size_t components = 0;
    std::vector<double> values;
  };
  std::map<std::string, Attribute> attributes;
};

/// Unpacks the attributes that `packed` (the extension) names.
///
/// A few bytes may announce a mesh of any size, so its numbers of triangles, points and attributes
/// are compared with the limits before the decoder allocates them.  Throws a StatusError:
/// INVALID_ARGUMENT if the bytes are no mesh, RESOURCE_EXHAUSTED over the limit of primitives, over
/// kMostUnpackedBytes, or if the budget refuses the decoder's memory.
DracoMesh unpack_draco(const View& packed, std::string_view bytes);

}  // namespace lucerna::gltf
