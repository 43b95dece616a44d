// Reads meshes from PLY files: ASCII, and binary of either byte order.  [Turk94]
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string_view>
#include <vector>

#include "lights/maths/vec.h"
#include "server/files/load_budget.h"

namespace lucerna {

struct PlyMesh {
  std::vector<Vec3> positions;         ///< finite
  std::vector<Vec3f> normals;          ///< any length or not finite, per vertex; empty: none
  std::vector<Vec2f> uv;               ///< finite, per vertex; empty: none
  std::vector<std::uint32_t> indices;  ///< three per triangle, all < positions.size()
  /// Quadrilaterals are split along their first diagonal: the first triangle of each.
  std::vector<std::uint32_t> quads;
  std::uint64_t short_faces = 0;  ///< of fewer than three corners, which are left out
  std::uint64_t long_faces = 0;   ///< of more than four corners, which are left out
  std::uint64_t mended_uv = 0;    ///< (u, v) that are not finite, which become 0, 0
  LoadBudget::Share share{};      ///< of all arrays
};

/// The mesh in the bytes of a PLY file.  Element `vertex` has x y z and optionally nx ny nz and u v
/// (or s t, texture_u texture_v, texture_s texture_t).  Element `face` has the list vertex_indices
/// (or vertex_index).  Faces of three and four corners are read, as in pbrt-v4.  Other elements and
/// properties are skipped.
///
/// Sizes in the header are checked against the length of the data before anything is allocated.
/// Errors (INVALID_ARGUMENT) name the header line or the element.  They are: invalid header,
/// truncated data, index out of range, a vertex of a face that is not finite.
/// CANCELLED on `stop`.  Refusals of `budget` (null: no limit).
absl::StatusOr<PlyMesh> parse_ply(std::string_view bytes, std::stop_token stop = {},
                                  LoadBudget* budget = nullptr);

}  // namespace lucerna
