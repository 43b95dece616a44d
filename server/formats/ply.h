// Meshes in PLY files: ASCII, and binary of either byte order.  [Turk94]
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string_view>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

struct PlyMesh {
  std::vector<Vec3<double>> positions;  ///< finite
  std::vector<Vec3<float>> normals;     ///< as written (any length), per vertex; empty: none
  std::vector<Vec2<float>> uv;          ///< finite, per vertex; empty: none
  std::vector<std::uint32_t> indices;   ///< three a triangle, all < positions.size()
  std::size_t split_quads = 0;          ///< faces of four, each split along its first diagonal
};

/// The mesh that the bytes of a PLY file hold: element `vertex` with x y z and maybe nx ny nz and
/// u v (or s t, texture_u texture_v, texture_s texture_t), element `face` with the list
/// vertex_indices (or vertex_index), three or four entries each. Other elements and properties are
/// skipped.
///
/// Sizes that the header claims are checked against what is there before anything is allocated.
/// Errors (INVALID_ARGUMENT) name the header line or the element: broken header, cut-off data,
/// index out of range, vertex not finite, face of other than three or four corners.  CANCELLED on
/// `stop`.
absl::StatusOr<PlyMesh> parse_ply(std::string_view bytes, std::stop_token stop = {});

}  // namespace lucerna
