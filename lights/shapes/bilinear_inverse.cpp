#include "lights/shapes/bilinear_inverse.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lucerna {

int solve_quadratic(double a, double b, double c, double (&x)[2]) {
  const double discriminant = b * b - 4 * a * c;
  if (!(discriminant >= 0)) return 0;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
  int count = 0;
  if (q != 0) x[count++] = c / q;
  if (a != 0) x[count++] = q / a;
  return count == 2 && x[0] == x[1] ? 1 : count;
}

int invert(const BilinearForm& p, const Vec3& position, double tolerance_m, Vec2 (&uv)[2]) {
  // Projected along the mean normal onto the coordinate plane that it is steepest to.
  Vec3 n = cross(p.e + p.f + p.g, p.f - p.e);
  if (!(max_abs(n) > 0)) n = p.area_vector(0, 0);
  const Vec3 size{std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)};
  const int drop = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  const auto cross2 = [i = (drop + 1) % 3, j = (drop + 2) % 3](const Vec3& a, const Vec3& b) {
    return a[i] * b[j] - a[j] * b[i];
  };
  // q - u e is parallel to f + u g.
  const Vec3 q = position - p.p00;
  double root[2];
  int count =
      solve_quadratic(-cross2(p.e, p.g), cross2(q, p.g) - cross2(p.e, p.f), cross2(q, p.f), root);
  // Rounding may move a point over the edge of the fold.  The vertex of the parabola is then
  // nearest.
  if (count == 0) {
    root[0] = (cross2(q, p.g) - cross2(p.e, p.f)) / (2 * cross2(p.e, p.g));
    count = 1;
  }
  double error[2];
  for (int i = 0; i < count; ++i) {
    const double u = std::isfinite(root[i]) ? std::clamp(root[i], 0.0, 1.0) : 0.5;
    const Vec3 line = p.f + p.g * u;
    const double v = dot(q - p.e * u, line) / dot(line, line);
    uv[i] = {u, std::isfinite(v) ? std::clamp(v, 0.0, 1.0) : 0.5};
    error[i] = length(p.at(uv[i].x, uv[i].y) - position);
  }
  if (count == 2) {
    if (error[1] < error[0]) {
      std::swap(uv[0], uv[1]);
      std::swap(error[0], error[1]);
    }
    if (!(error[1] <= tolerance_m) || uv[0] == uv[1]) count = 1;
  }
  return count;
}

Vec2 nearest(const BilinearForm& p, const Vec3& q) {
  Vec2 uv[2];
  invert(p, q, 0, uv);
  // Small errors of the position cause large errors of (u, v) in needles.  They also do so where
  // the patch is parallel to the direction of projection.  Steps to the nearest point of the
  // tangent plane correct them.
  Vec2 best = uv[0];
  double error = length(p.at(best.x, best.y) - q);
  const auto improve = [&](const Vec2& next) {
    const double left = length(p.at(next.x, next.y) - q);
    if (!(left < error)) return false;
    best = next, error = left;
    return true;
  };
  constexpr int kSteps = 4;
  for (int i = 0; i < kSteps && error > 0; ++i) {
    const Vec3 off = q - p.at(best.x, best.y);
    const Vec3 du = p.e + p.g * best.y, dv = p.f + p.g * best.x;
    const double uu = dot(du, du), u_v = dot(du, dv), vv = dot(dv, dv);
    const double determinant = uu * vv - u_v * u_v;
    const Vec2 next{
        std::clamp(best.x + (vv * dot(du, off) - u_v * dot(dv, off)) / determinant, 0.0, 1.0),
        std::clamp(best.y + (uu * dot(dv, off) - u_v * dot(du, off)) / determinant, 0.0, 1.0)};
    if (!improve(next)) break;
  }
  if (!(error > 0)) return best;
  // Where the sides are almost parallel, the nearest point of an edge is not where the step leaves
  // the patch.
  for (const double end : {0.0, 1.0}) {
    const Vec3 du = p.e + p.g * end, dv = p.f + p.g * end;
    improve({std::clamp(dot(q - p.at(0, end), du) / dot(du, du), 0.0, 1.0), end});
    improve({end, std::clamp(dot(q - p.at(end, 0), dv) / dot(dv, dv), 0.0, 1.0)});
  }
  return best;
}

}  // namespace lucerna
