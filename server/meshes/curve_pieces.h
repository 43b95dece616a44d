// Cubic Bezier curves from the control points of a Bezier curve or a B-spline.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <vector>

#include "server/description/scene_description.h"

namespace lucerna {

struct CurveControl {
  std::vector<Vec3<double>> points{};
  int degree = 3;            ///< 2 or 3
  bool is_b_spline = false;  ///< with even knots; else a chain of Bezier curves
  double start_width_m = 1, end_width_m = 1;
  /// Of a ribbon: unit, one more than curves; else empty.
  std::vector<Vec3<double>> normals{};
};

/// The most curves of one CurveControl.
inline constexpr std::size_t kMostCurves = std::size_t{1} << 20;

/// The curves, of degree 3.  Widths change evenly from the first to the last.  Errors
/// (INVALID_ARGUMENT): too few points, a number of points that does not end a Bezier curve, a wrong
/// number of normals.  RESOURCE_EXHAUSTED above kMostCurves.
absl::StatusOr<std::vector<CubicCurve>> cubic_curves(const CurveControl& control);

}  // namespace lucerna
