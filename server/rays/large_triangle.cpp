#include "server/rays/large_triangle.h"

#include <algorithm>
#include <cmath>

#include "server/rays/error_bounds.h"

namespace lucerna {

double ray_error_of(const std::array<Vec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const auto extent = [](double x, double y, double z) {
    return std::max({x, y, z}) - std::min({x, y, z});
  };
  const double area2 = length(cross(b - a, c - a));
  // 2 D_i D_j bounds the products of two edges, and D_k the distance of a vertex.
  const double products = extent(a.x, b.x, c.x) * extent(a.y, b.y, c.y) * extent(a.z, b.z, c.z);
  return area2 > 0 ? 6 * kTraversalBound * products / area2 : 0;
}

// The ray passes all edges on one side: the triple products of the ray with each edge have one
// sign.  Swapping the ends of an edge only changes the sign of its product, so triangles with a
// common edge agree on its side.
std::optional<WideHit> intersect(const LargeTriangle& triangle, const Vec3& origin,
                                 const Vec3& direction, double t_min, double t_max) {
  const Vec3 a = triangle.corners[0] - origin, b = triangle.corners[1] - origin,
             c = triangle.corners[2] - origin;
  const double of_a = dot(direction, cross(b, c)), of_b = dot(direction, cross(c, a)),
               of_c = dot(direction, cross(a, b));
  if (std::min({of_a, of_b, of_c}) < 0 && std::max({of_a, of_b, of_c}) > 0) return std::nullopt;
  const double sum = of_a + of_b + of_c;
  const Vec3 normal =
      cross(triangle.corners[1] - triangle.corners[0], triangle.corners[2] - triangle.corners[0]);
  const double t = dot(normal, a) / dot(normal, direction);
  if (sum == 0 || !(t > t_min && t < t_max)) return std::nullopt;
  return WideHit{t, {of_b / sum, of_c / sum}};
}

}  // namespace lucerna
