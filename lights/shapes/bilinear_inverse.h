// From points of a bilinear patch to their (u, v).
#pragma once

#include "lights/shapes/bilinear_form.h"

namespace lucerna {

/// The real roots of a x^2 + b x + c, without differences that cancel.  Returns how many.
int solve_quadratic(double a, double b, double c, double (&x)[2]);

/// Finds the (u, v) whose points are at `position`, up to its rounding by `tolerance_m`.  Returns
/// two if a patch folds over itself there, else the best one.
int invert(const BilinearForm& p, const Vec3& position, double tolerance_m, Vec2 (&uv)[2]);

/// The (u, v) in [0, 1]^2 of a point near `position`: the nearest one, up to rounding, if the
/// position is near the patch.
Vec2 nearest(const BilinearForm& p, const Vec3& position);

}  // namespace lucerna
