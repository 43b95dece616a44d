// Counts the primitives of a mesh that get a remark.
#pragma once

#include <cstddef>

#include "server/description/scene_description.h"

namespace lucerna {

struct Census {
  std::size_t without_area = 0;
  std::size_t crossed = 0;  ///< flat patches whose edges cross
};

Census census_of(const TriangleMeshData& mesh);
Census census_of(const PatchMeshData& mesh);

}  // namespace lucerna
