// A bilinear patch as a polynomial, and the integral of its area.
#pragma once

#include "lights/shapes/bilinear_patch.h"

namespace lucerna {

/// The patch in double, as p00 + u e + v f + u v g.
struct BilinearForm {
  Vec3 p00, e, f, g;

  explicit BilinearForm(const BilinearPatch& patch)
      : p00(patch.p00), e(patch.p10 - p00), f(patch.p01 - p00), g((patch.p11 - patch.p10) - f) {}

  Vec3 at(double u, double v) const { return p00 + e * u + (f + g * u) * v; }
  /// dp/du x dp/dv, which is linear in u and in v.
  Vec3 area_vector(double u, double v) const { return cross(e + g * v, f + g * u); }
};

/// The area of the patch, by quadrature with a bound on its error.  The bound is at most
/// `tolerance_m2`, except for patches that fold along a line.
BilinearPatchArea integrate_area(const BilinearForm& patch, double tolerance_m2);

}  // namespace lucerna
