#include "server/materials/microfacet.h"

#include <algorithm>

#include "lights/sampling/sampling.h"

namespace lucerna {

// The visible half of a sphere projects to a disk across `w`.  The disk is cut where the surface
// hides it, and its points are raised to the sphere.  [Heitz18b, 3]
Vec3 Microfacets::sample(const Vec3& w, Vec2 u) const {
  const Vec3 wh = normalized(Vec3{x_ * w.x, y_ * w.y, w.z});
  const Vec3 t1 = wh.z < 0.99999 ? normalized(cross(Vec3{0, 0, 1}, wh)) : Vec3{1, 0, 0};
  const Vec3 t2 = cross(wh, t1);
  Vec2 p = sample_concentric_disk(u);
  const double half = std::sqrt(std::max(0.0, 1 - p.x * p.x));
  const double share = (1 + wh.z) / 2;
  p.y = (1 - share) * half + share * p.y;
  const double height = std::sqrt(std::max(0.0, 1 - p.x * p.x - p.y * p.y));
  const Vec3 n = t1 * p.x + t2 * p.y + wh * height;
  return normalized(Vec3{x_ * n.x, y_ * n.y, std::max(1e-6, n.z)});
}

}  // namespace lucerna
