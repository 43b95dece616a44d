// Counts the unusual primitives of a mesh.
#pragma once

#include <cstddef>

#include "server/description/scene_description.h"

namespace lucerna {

struct Census {
  std::size_t without_area = 0;  ///< rays do not meet them, and they give no light
  std::size_t crossed = 0;       ///< flat patches whose edges cross
};

Census census_of(const TriangleMeshData& mesh);
Census census_of(const PatchMeshData& mesh);

}  // namespace lucerna
