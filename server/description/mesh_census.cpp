#include "server/description/mesh_census.h"

#include <array>

#include "lights/maths/stop_poll.h"

namespace lucerna {

Census census_of(const TriangleMeshData& mesh) {
  Census census;
  StopPoll poll;
  for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3, poll()) {
    const auto p = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
    if (max_abs(cross(p(1) - p(0), p(2) - p(0))) == 0) ++census.without_area;
  }
  return census;
}

/// dp/du x dp/dv of a patch is linear in u and in v, so a patch has no area if it is 0 at all four
/// corners.  On a flat patch it gives the turns of the outline.  The outline crosses itself if two
/// corners turn one way and two the other.  With one different turn it is an arrowhead.
Census census_of(const PatchMeshData& mesh) {
  Census census;
  StopPoll poll;
  for (std::size_t i = 0; i + 4 <= mesh.indices.size(); i += 4, poll()) {
    const auto p = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
    const std::array<Vec3, 4> turns{
        cross(p(1) - p(0), p(2) - p(0)), cross(p(1) - p(0), p(3) - p(1)),
        cross(p(3) - p(2), p(2) - p(0)), cross(p(3) - p(2), p(3) - p(1))};
    Vec3 largest{};
    for (const Vec3& turn : turns)
      if (max_abs(turn) > max_abs(largest)) largest = turn;
    if (max_abs(largest) == 0) {
      ++census.without_area;
      continue;
    }
    constexpr double kRounded = 1e-6;  // relative to the largest, from rounding of corners
    const Vec3 axis = normalized(largest);
    const double unit = length(largest);
    int left = 0, right = 0;
    for (const Vec3& turn : turns) {
      const Vec3 t = turn / unit;
      if (max_abs(cross(axis, t)) > kRounded) break;
      left += dot(axis, t) > kRounded;
      right += dot(axis, t) < -kRounded;
    }
    if (left == 2 && right == 2) ++census.crossed;
  }
  return census;
}

}  // namespace lucerna
