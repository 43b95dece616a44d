// A bilinear patch as a polynomial, and the integral of its area.
#pragma once

#include "lights/shapes/bilinear_patch.h"

namespace lucerna {

/// The patch in double, as p00 + u e + v f + u v g.
struct BilinearForm {
  Vec3<double> p00, e, f, g;

  template <typename Real>
  explicit BilinearForm(const BilinearPatch<Real>& patch)
      : p00(patch.p00),
        e(Vec3<double>(patch.p10) - p00),
        f(Vec3<double>(patch.p01) - p00),
        g((Vec3<double>(patch.p11) - Vec3<double>(patch.p10)) - f) {}

  Vec3<double> at(double u, double v) const { return p00 + e * u + (f + g * u) * v; }
  /// dp/du x dp/dv, which is linear in u and in v.
  Vec3<double> area_vector(double u, double v) const { return cross(e + g * v, f + g * u); }
};

/// The area of the patch, by quadrature with a bound on its error.  The bound is at most
/// `tolerance_m2`, except for patches that fold along a line.
BilinearPatchArea integrate_area(const BilinearForm& patch, double tolerance_m2);

}  // namespace lucerna
