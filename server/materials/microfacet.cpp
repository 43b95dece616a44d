#include "server/materials/microfacet.h"

#include <algorithm>

#include "lights/sampling/sampling.h"

namespace lucerna {

// The visible half of a sphere projects to a disk across `w`.  The disk is cut where the surface
// hides it, and its points are raised to the sphere.  [Heitz18b, 3]
template <std::floating_point Real>
Vec3<Real> Microfacets<Real>::sample(const Vec3<Real>& w, Vec2<Real> u) const {
  const Vec3<Real> wh = normalized(Vec3<Real>{x_ * w.x, y_ * w.y, w.z});
  const Vec3<Real> t1 =
      wh.z < Real(0.99999) ? normalized(cross(Vec3<Real>{0, 0, 1}, wh)) : Vec3<Real>{1, 0, 0};
  const Vec3<Real> t2 = cross(wh, t1);
  Vec2<Real> p = sample_concentric_disk(u);
  const Real half = std::sqrt(std::max(Real(0), 1 - p.x * p.x));
  const Real share = (1 + wh.z) / 2;
  p.y = (1 - share) * half + share * p.y;
  const Real height = std::sqrt(std::max(Real(0), 1 - p.x * p.x - p.y * p.y));
  const Vec3<Real> n = t1 * p.x + t2 * p.y + wh * height;
  return normalized(Vec3<Real>{x_ * n.x, y_ * n.y, std::max(Real(1e-6), n.z)});
}

template class Microfacets<float>;
template class Microfacets<double>;

}  // namespace lucerna
