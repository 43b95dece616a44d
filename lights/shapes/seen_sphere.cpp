#include "lights/shapes/seen_sphere.h"

#include <algorithm>
#include <cmath>

#include "lights/maths/turn.h"
#include "lights/sampling/sampling.h"
#include "lights/shapes/shape.h"

namespace lucerna {

namespace {

/// The cone of the directions that meet the sphere.
struct Cone {
  double tangent_m;      ///< length of a tangent from the viewpoint
  double one_minus_cos;  ///< of the half-angle
  double pdf_per_sr;

  explicit Cone(const SeenSphere& s)
      : tangent_m(std::sqrt((s.distance - s.radius_m) * (s.distance + s.radius_m))) {
    // sin^2 / (1 + cos): 1 - cos would cancel for small spheres.  At 3e-4 in float it loses a
    // quarter.
    const double r2 = s.radius_m * s.radius_m, d2 = s.distance * (s.distance + tangent_m);
    one_minus_cos = r2 / d2;
    pdf_per_sr = d2 / (kTurnRad * r2);
  }
};

}  // namespace

double SeenSphere::pdf_from_outside() const { return Cone(*this).pdf_per_sr; }

SeenSphere::Point SeenSphere::from_outside(Vec2 u) const {
  const double r = radius_m;
  const double d = distance;
  const double a = std::clamp(u.x, 0.0, 1.0);
  const CosSin phi = cos_sin_of_turn(std::clamp(u.y, 0.0, 1.0));
  const Cone cone(*this);

  // theta: the angle at the receiver between the centre and the sampled direction; 1 - cos is
  // uniform.
  const double one_minus_cos = a * cone.one_minus_cos;
  const double cos_theta = 1 - one_minus_cos;
  const double sin2_theta = one_minus_cos * (2 - one_minus_cos);
  const double sin_theta = std::sqrt(sin2_theta);
  // Half the chord of the direction, in radii: sqrt(1 - (d sin_theta / r)^2).  Both differences are
  // expanded, so that it is exact at the rim.
  const double half_chord =
      std::sqrt((1 - a) * (2 - cone.one_minus_cos * (1 + a)) * (d / (d + cone.tangent_m)));
  // Distance of the near intersection: the product of both, the square of the tangent, over the far
  // one.
  const double t = (d - r) * (d + r) / (d * cos_theta + r * half_chord);

  // alpha: the angle at the centre between the receiver and the point.  Its sine comes from the
  // height of the point over the axis, which is exact close to the sphere.  Its cosine comes from
  // the chord, which is exact far from it.
  const double per_radius = 1 / r;
  const double height = t * sin_theta * per_radius;
  const double along = sin2_theta * (d * per_radius) + cos_theta * half_chord;
  // Both have errors of a few roundings.  One step of Newton's method for 1 / sqrt(x) from 1 makes
  // the sum of their squares 1.
  const double to_unit = 1.5 - 0.5 * (height * height + along * along);
  const double sin_alpha = height * to_unit;
  const double cos_alpha = along * to_unit;

  const auto frame = Frame::around(to_center * (-1 / d));
  const Vec3 outward =
      frame.world_from_local({sin_alpha * phi.cos, sin_alpha * phi.sin, cos_alpha});
  Point p{.from_center = outward * r, .normal = outward, .pdf_per_sr = cone.pdf_per_sr};
  // Just above the surface, rounding moves points by more than their distance.
  constexpr double kNear = 1e-3;
  if (d - r < kNear * r)
    p.to_point =
        frame.world_from_local({t * sin_theta * phi.cos, t * sin_theta * phi.sin, -t * cos_theta});
  return p;
}

SeenSphere::Point SeenSphere::from_within(Vec2 u) const {
  const double r = radius_m;
  const Vec3 w = sample_uniform_sphere(u);
  // The roots of t^2 - 2 t (w.c) - (r - d)(r + d) have different signs.  This is the positive one,
  // computed as a quotient where it would cancel.
  const double along = dot(w, to_center);
  const double product = (r - distance) * (r + distance);
  const double root = std::sqrt(along * along + product);
  const double t = along > 0 ? along + root : product / (root - along);
  const Vec3 outward = (w * t - to_center) / r;
  return {outward * r, normalized(outward), uniform_sphere_pdf().per_sr};
}

}  // namespace lucerna
