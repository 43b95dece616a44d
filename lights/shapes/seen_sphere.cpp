#include "lights/shapes/seen_sphere.h"

#include <algorithm>
#include <cmath>

#include "lights/sampling/sampling.h"
#include "lights/shapes/shape.h"

namespace lucerna {

double SeenSphere::one_minus_cos_cone() const {
  const double r = radius_m;
  const double sin_cone = r / distance;
  const double cos_cone = std::sqrt((distance - r) * (distance + r)) / distance;
  // sin^2 / (1 + cos): 1 - cos would cancel for small spheres.  At 3e-4 in float it loses a
  // quarter.
  return sin_cone / (1 + cos_cone) * sin_cone;
}

double SeenSphere::pdf_from_outside() const { return 1 / (kTurnRad * one_minus_cos_cone()); }

SeenSphere::Point SeenSphere::from_outside(Vec2<double> u) const {
  const double r = radius_m;
  const double d = distance;
  const double a = std::clamp(u.x, 0.0, 1.0);
  const double phi = kTurnRad * u.y;
  const double cone = one_minus_cos_cone();

  // theta: the angle at the receiver between the centre and the sampled direction; 1 - cos is
  // uniform.
  const double one_minus_cos = a * cone;
  const double cos_theta = 1 - one_minus_cos;
  const double sin_theta = std::sqrt(one_minus_cos * (2 - one_minus_cos));
  // Half the chord of the direction, in radii: sqrt(1 - (d sin_theta / r)^2).  Both differences are
  // expanded, so that it is exact at the rim.
  const double half_chord = std::sqrt((1 - a) * (2 - cone * (1 + a)) / (2 - cone));
  // Distance of the near intersection: the product of both, (d - r)(d + r), over the far one.
  const double t = (d - r) * (d + r) / (d * cos_theta + r * half_chord);

  // alpha: the angle at the centre between the receiver and the point.  Its sine comes from the
  // height of the point over the axis, which is exact close to the sphere.  Its cosine comes from
  // the chord, which is exact far from it.
  const double height = t * sin_theta / r;
  const double along = sin_theta * sin_theta * d / r + cos_theta * half_chord;
  const double norm = std::sqrt(height * height + along * along);
  const double sin_alpha = height / norm;
  const double cos_alpha = along / norm;

  const auto frame = Frame<double>::around(-(to_center / d));
  const Vec3<double> outward =
      frame.world_from_local({sin_alpha * std::cos(phi), sin_alpha * std::sin(phi), cos_alpha});
  Point p{outward * r, outward};
  // Just above the surface, rounding moves points by more than their distance.
  constexpr double kNear = 1e-3;
  if (d - r < kNear * r)
    p.to_point = frame.world_from_local(
        {t * sin_theta * std::cos(phi), t * sin_theta * std::sin(phi), -t * cos_theta});
  return p;
}

SeenSphere::Point SeenSphere::from_within(Vec2<double> u) const {
  const double r = radius_m;
  const Vec3<double> w = sample_uniform_sphere(u);
  // The roots of t^2 - 2 t (w.c) - (r - d)(r + d) have different signs.  This is the positive one,
  // computed as a quotient where it would cancel.
  const double along = dot(w, to_center);
  const double product = (r - distance) * (r + distance);
  const double root = std::sqrt(along * along + product);
  const double t = along > 0 ? along + root : product / (root - along);
  const Vec3<double> outward = (w * t - to_center) / r;
  return {outward * r, normalized(outward)};
}

}  // namespace lucerna
