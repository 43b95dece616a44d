#include "lights/models/light_cluster.h"

#include <algorithm>
#include <cmath>

#include "lights/maths/normal_cone.h"

namespace lucerna {

void LightCluster::add(const LightCluster& other) {
  if (other.empty()) return;
  if (empty()) {
    *this = other;
    return;
  }
  lower = {std::min(lower.x, other.lower.x), std::min(lower.y, other.lower.y),
           std::min(lower.z, other.lower.z)};
  upper = {std::max(upper.x, other.upper.x), std::max(upper.y, other.upper.y),
           std::max(upper.z, other.upper.z)};
  power += other.power;
  has_cosine |= other.has_cosine;
  two_sided |= other.two_sided;
  add_cone(other);
}

// The smallest cone about both: its axis lies in the plane of theirs.  [Conty18, algorithm 1]
void LightCluster::add_cone(const LightCluster& other) {
  const bool is_wider = theta_o_rad >= other.theta_o_rad;
  const Vec3 wide = is_wider ? axis : other.axis;
  Vec3 narrow = is_wider ? other.axis : axis;
  const double wide_rad = std::max(theta_o_rad, other.theta_o_rad);
  const double narrow_rad = std::min(theta_o_rad, other.theta_o_rad);
  axis = wide;
  theta_o_rad = wide_rad;
  if (wide_rad >= kPi) return;
  // The normals lie about an axis or about its opposite.  Use the direction nearer to the other
  // cone.
  if (two_sided && dot(wide, narrow) < 0) narrow = -narrow;
  if (wide == narrow) return;
  const double between = angle_between(wide, narrow);
  if (between + narrow_rad <= wide_rad) return;
  theta_o_rad = (wide_rad + between + narrow_rad) / 2;
  const Vec3 across = normalized(narrow - wide * dot(wide, narrow));
  if (theta_o_rad >= (two_sided ? kPi / 2 : kPi) || across == Vec3{}) {
    theta_o_rad = kPi;
    return;
  }
  const double turn = theta_o_rad - wide_rad;
  axis = normalized(wide * std::cos(turn) + across * std::sin(turn));
}

double LightCluster::solid_angle_sr() const {
  const double o = theta_o_rad;
  if (o >= kPi) return 4 * kPi;
  const double half = std::sin(o / 2);
  double cone = 4 * kPi * half * half;
  if (has_cosine) {
    const double w = std::min(o + kPi / 2, kPi);
    cone += kPi / 2 * (2 * (w - o) * std::sin(o) - std::cos(o - 2 * w) + std::cos(o));
  }
  return two_sided ? std::min(2 * cone, 4 * kPi) : cone;
}

double LightCluster::cost() const {
  if (empty()) return 0;
  const Vec3 diagonal = upper - lower;
  return power * dot(diagonal, diagonal) * solid_angle_sr();
}

}  // namespace lucerna
