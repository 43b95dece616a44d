#include "tests/oracle/shapes.h"

#include <limits>

namespace lucerna::oracle {
namespace {

/// The corners in order around the shape.
std::vector<Vec> outline(const Shape& shape) {
  const auto& [a, b, c] = shape.at;
  if (shape.kind == ShapeKind::kTriangle) return {a, b, c};
  return {a, b, b + (c - a), c};
}

}  // namespace

std::vector<Vec> hull(const Shape& shape) {
  const auto& [a, b, c] = shape.at;
  if (shape.kind == ShapeKind::kTriangle) return {a, b, c};
  if (shape.kind == ShapeKind::kParallelogram) return {a, b, c, b + (c - a)};
  Vec reach{shape.radius, shape.radius, shape.radius};
  if (shape.kind == ShapeKind::kDisk) {
    const Vec n = unit(b - a);
    reach = {std::sqrt(std::fmax(0, 1 - n.x * n.x)) * shape.radius,
             std::sqrt(std::fmax(0, 1 - n.y * n.y)) * shape.radius,
             std::sqrt(std::fmax(0, 1 - n.z * n.z)) * shape.radius};
  }
  return {a - reach, a + reach};
}

Vec normal_of(const Shape& shape) {
  const auto& [a, b, c] = shape.at;
  return shape.kind == ShapeKind::kDisk ? unit(b - a) : unit(cross(b - a, c - a));
}

std::vector<Vec> surroundings(const Shape& shape) {
  if (shape.kind != ShapeKind::kDisk) return outline(shape);
  constexpr int kCorners = 64;
  const Vec n = normal_of(shape);
  const Vec u = across(n), v = cross(n, u);
  std::vector<Vec> corners;
  for (int i = 0; i < kCorners; ++i) {
    const Real angle = 2 * kPi * i / kCorners;
    corners.push_back(shape.at[0] + (u * std::cos(angle) + v * std::sin(angle)) *
                                        (shape.radius / std::cos(kPi / kCorners)));
  }
  return corners;
}

Real inside_by(const Shape& shape, const Vec& n, const Vec& p) {
  if (shape.kind == ShapeKind::kDisk) return shape.radius - length(p - shape.at[0]);
  const std::vector<Vec> corners = outline(shape);
  Real least = std::numeric_limits<Real>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec edge = corners[(i + 1) % corners.size()] - corners[i];
    least = std::fmin(least, dot(cross(n, edge), p - corners[i]) / length(edge));
  }
  return least;
}

}  // namespace lucerna::oracle
