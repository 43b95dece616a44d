// The steps from the vertices of a file to a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "lights/maths/stop_poll.h"
#include "lights/maths/vec.h"

namespace lucerna {

/// Vertices and primitives of a file, with `corners` indices for each primitive.
struct RawMesh {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;
  std::vector<std::uint32_t> indices;
  std::vector<Vec2f> uv;  ///< per vertex; empty: the default (u, v) of each primitive
};

/// Orients each primitive so that its winding gives the outside.  Vertex normals point to the
/// outside.  Without them, either a mirror or ReverseOrientation (not both) turns the primitive.
/// `geometric_normal(corners)` has any length.
template <std::size_t kCorners, typename Mesh, typename F>
void resolve_winding(Mesh& mesh, bool turned, F&& geometric_normal) {
  StopPoll poll;
  for (std::size_t i = 0; i + kCorners <= mesh.indices.size(); i += kCorners, poll()) {
    std::uint32_t* corner = &mesh.indices[i];
    std::array<Vec3, kCorners> p;
    Vec3 n{};
    for (std::size_t k = 0; k < kCorners; ++k) {
      p[k] = mesh.positions[corner[k]];
      if (!mesh.normals.empty()) n += Vec3(mesh.normals[corner[k]]);
    }
    const Vec3 outside = geometric_normal(p);
    if (mesh.normals.empty() ? turned : dot(normalized(outside), n) < 0) {
      std::swap(corner[1], corner[2]);
      if (!mesh.corner_uv.empty()) std::swap(mesh.corner_uv[i + 1], mesh.corner_uv[i + 2]);
    }
  }
}

/// Replaces vertex normals of 0 by the mean normal of the faces around the vertex.  A face takes
/// the side of its other normals, or without any the side that `turned` says.  Empties the normals
/// if all are 0.  Returns how many were 0.
template <std::size_t kCorners, typename Mesh, typename F>
std::size_t mend_normals(Mesh& mesh, bool turned, F&& geometric_normal) {
  const auto is_missing = [](const Vec3f& n) { return n == Vec3f{}; };
  const auto count = static_cast<std::size_t>(std::ranges::count_if(mesh.normals, is_missing));
  if (count == mesh.normals.size()) mesh.normals.clear();
  if (count == 0 || mesh.normals.empty()) return count;
  std::vector<bool> missing(mesh.normals.size());
  StopPoll poll;
  for (std::size_t i = 0; i < missing.size(); ++i, poll()) missing[i] = is_missing(mesh.normals[i]);
  for (std::size_t i = 0; i + kCorners <= mesh.indices.size(); i += kCorners, poll()) {
    const std::uint32_t* corner = &mesh.indices[i];
    std::array<Vec3, kCorners> p;
    Vec3 others{};
    bool is_needed = false;
    for (std::size_t k = 0; k < kCorners; ++k) {
      p[k] = mesh.positions[corner[k]];
      is_needed |= missing[corner[k]];
      if (!missing[corner[k]]) others += Vec3(mesh.normals[corner[k]]);
    }
    const Vec3 n = is_needed ? normalized(geometric_normal(p)) : Vec3{};
    if (!is_finite(n) || n == Vec3{}) continue;
    const double side = dot(n, others);
    const bool flips = side != 0 ? side < 0 : turned;
    for (std::size_t k = 0; k < kCorners; ++k)
      if (missing[corner[k]]) mesh.normals[corner[k]] += Vec3f(flips ? -n : n);
  }
  for (std::size_t i = 0; i < missing.size(); ++i, poll()) {
    const Vec3f n = normalized(mesh.normals[i]);
    if (missing[i]) mesh.normals[i] = is_finite(n) ? n : Vec3f{};
  }
  return count;
}

/// The (u, v) of every corner, as in pbrt-v4: those of the vertices, or the defaults of each
/// primitive.
template <std::size_t kCorners>
std::vector<Vec2f> corner_uvs(const RawMesh& raw) {
  static constexpr std::array<Vec2f, 4> kTriangle{{{0, 0}, {1, 0}, {1, 1}}};
  static constexpr std::array<Vec2f, 4> kPatch{{{0, 0}, {1, 0}, {0, 1}, {1, 1}}};
  std::vector<Vec2f> uv;
  uv.reserve(raw.indices.size());
  StopPoll poll;
  for (std::size_t i = 0; i < raw.indices.size(); ++i, poll())
    uv.push_back(raw.uv.empty() ? (kCorners == 3 ? kTriangle : kPatch)[i % kCorners]
                                : raw.uv[raw.indices[i]]);
  return uv;
}

/// Whether each patch shows the whole image, without a flip.
inline bool shows_all_on_each(const std::vector<Vec2f>& corner_uv) {
  StopPoll poll;
  for (std::size_t i = 0; i < corner_uv.size(); ++i, poll())
    if (!(corner_uv[i] == Vec2f{float(i & 1), float(i >> 1 & 1)})) return false;
  return true;
}

}  // namespace lucerna
