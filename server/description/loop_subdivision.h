// Loop subdivision of a triangle mesh, to points and normals of its limit surface.  [Loop87]
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <stop_token>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

struct ControlMesh {
  std::vector<Vec3> positions;
  std::vector<std::uint32_t> indices;  ///< three per triangle
};

struct LimitMesh {
  std::vector<Vec3> positions;         ///< on the limit surface
  std::vector<Vec3> normals;           ///< of the limit surface, any length, one per vertex
  std::vector<std::uint32_t> indices;  ///< three per triangle, with the winding of the control mesh
};

/// The most triangles of a LimitMesh.
inline constexpr std::uint64_t kMostLimitTriangles = std::uint64_t{1} << 24;

/// Refines the mesh `levels` times and moves its vertices to the limit surface.
///
/// Weights and boundaries are those of pbrt-v4, so that pictures agree.  A vertex of valence n has
/// the weight 3/8 for the sum of its neighbours, and 3/16 for each if n is 3 [Warren95].  Boundary
/// vertices end at 3/5 of themselves and 1/5 of each neighbour on the boundary.  Normals point
/// against the winding: that is where surfaces of pbrt-v4 have their outside.  [Pharr16, 3.8]
///
/// Vertices without a triangle are left out.  Errors (INVALID_ARGUMENT): an index out of range, a
/// triangle with a vertex twice, an edge with three triangles or with two of opposite winding, a
/// vertex where two parts of the surface touch.  RESOURCE_EXHAUSTED above kMostLimitTriangles.
/// CANCELLED on `stop`.  Requires levels >= 0.
absl::StatusOr<LimitMesh> loop_subdivide(ControlMesh mesh, int levels, std::stop_token stop = {});

}  // namespace lucerna
