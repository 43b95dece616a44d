#include "server/description/curve_pieces.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <array>

namespace lucerna {
namespace {

/// The same curve with one degree more.
std::array<Vec3, 4> raised(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {a, (a + b * 2.0) / 3.0, (b * 2.0 + c) / 3.0, c};
}

/// The curve of a B-spline with even knots between two of its knots.
std::array<Vec3, 4> between_knots(const Vec3* p, int degree) {
  if (degree == 2) return raised((p[0] + p[1]) * 0.5, p[1], (p[1] + p[2]) * 0.5);
  return {(p[0] + p[1] * 4.0 + p[2]) / 6.0, (p[1] * 2.0 + p[2]) / 3.0, (p[1] + p[2] * 2.0) / 3.0,
          (p[1] + p[2] * 4.0 + p[3]) / 6.0};
}

}  // namespace

absl::Status check_curves(const CurveData& curves) {
  const std::size_t n = curves.points.size(), degree = static_cast<std::size_t>(curves.degree);
  if (n < degree + 1)
    return absl::InvalidArgumentError(fmt::format(
        "{} control points, allowed: at least {} for degree {}", n, degree + 1, degree));
  if (!curves.is_b_spline && (n - 1) % degree != 0)
    return absl::InvalidArgumentError(
        fmt::format("{} control points of Bezier curves of degree {}, allowed: 1 more than a "
                    "multiple of {}",
                    n, degree, degree));
  const std::size_t count = curves.count();
  if (count > kMostCurves)
    return absl::ResourceExhaustedError(
        fmt::format("{} curves in one shape, allowed: at most {}", count, kMostCurves));
  if (!curves.normals.empty() && curves.normals.size() != count + 1)
    return absl::InvalidArgumentError(
        fmt::format("{} normals of a ribbon with {} curves, allowed: {}", curves.normals.size(),
                    count, count + 1));
  return absl::OkStatus();
}

CubicCurve cubic_curve(const CurveData& curves, std::size_t i) {
  const std::size_t count = curves.count(), degree = static_cast<std::size_t>(curves.degree);
  const auto width = [&](std::size_t joint) {
    const double share = static_cast<double>(joint) / static_cast<double>(count);
    return curves.start_width_m * (1 - share) + curves.end_width_m * share;
  };
  CubicCurve curve;
  const Vec3* p = &curves.points[curves.is_b_spline ? i : i * degree];
  if (curves.is_b_spline)
    curve.points = between_knots(p, curves.degree);
  else
    curve.points = degree == 2 ? raised(p[0], p[1], p[2]) : std::array{p[0], p[1], p[2], p[3]};
  curve.start_width_m = width(i), curve.end_width_m = width(i + 1);
  if (!curves.normals.empty()) curve.normals = {curves.normals[i], curves.normals[i + 1]};
  return curve;
}

}  // namespace lucerna
