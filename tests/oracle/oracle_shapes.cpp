#include "tests/oracle/oracle_shapes.h"

#include <limits>

namespace lucerna::oracle {
namespace {

/// The corners in order around the shape.
std::vector<Vec> outline(const Shape& shape) {
  const auto& [a, b, c, d] = shape.at;
  if (shape.kind == ShapeKind::kTriangle) return {a, b, c};
  return {a, b, b + (c - a), c};
}

/// The extent of a disk along each axis.
Vec reach_of_disk(const Vec& n, Real radius) {
  const auto one = [&](Real x) { return std::sqrt(std::fmax(0, 1 - x * x)) * radius; };
  return {one(n.x), one(n.y), one(n.z)};
}

/// dP/ds x dP/dt of a patch.
Vec stretch(const Shape& shape, Real s, Real t) {
  const auto& [a, b, c, d] = shape.at;
  return cross((b - a) * (1 - t) + (d - c) * t, (c - a) * (1 - s) + (d - b) * s);
}

Real area_in_cells(const Shape& shape, int cells) {
  Real sum = 0;
  for (int i = 0; i < cells * cells; ++i) {
    for (const Real x : {-1, 1}) {
      for (const Real y : {-1, 1}) {
        const Real g = 1 / (2 * std::sqrt(3.0L));  // Gauss, two points in each direction
        sum += length(
            stretch(shape, (i % cells + 0.5L + g * x) / cells, (i / cells + 0.5L + g * y) / cells));
      }
    }
  }
  return sum / (4 * cells * cells);
}

}  // namespace

std::vector<Vec> hull(const Shape& shape) {
  const auto& [a, b, c, d] = shape.at;
  switch (shape.kind) {
    case ShapeKind::kTriangle:
      return {a, b, c};
    case ShapeKind::kParallelogram:
      return {a, b, c, b + (c - a)};
    case ShapeKind::kPatch:
      return {a, b, c, d};
    case ShapeKind::kDisk: {
      const Vec reach = reach_of_disk(b, shape.radius);
      return {a - reach, a + reach};
    }
    case ShapeKind::kSphere: {
      const Vec reach{shape.radius, shape.radius, shape.radius};
      return {a - reach, a + reach};
    }
    case ShapeKind::kCylinder: {
      const Vec reach = reach_of_disk(b, shape.radius) + absolute(b) * shape.half_height;
      return {a - reach, a + reach};
    }
  }
  return {};
}

Vec normal_of(const Shape& shape) {
  const auto& [a, b, c, d] = shape.at;
  return shape.kind == ShapeKind::kDisk ? b : unit(cross(b - a, c - a));
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

SurfacePoint point_of(const Shape& shape, Real s, Real t) {
  const auto& [a, b, c, d] = shape.at;
  switch (shape.kind) {
    case ShapeKind::kTriangle:
      if (s + t > 1) s = 1 - s, t = 1 - t;
      [[fallthrough]];
    case ShapeKind::kParallelogram:
      return {a + (b - a) * s + (c - a) * t, normal_of(shape)};
    case ShapeKind::kPatch:
      return {(a * (1 - s) + b * s) * (1 - t) + (c * (1 - s) + d * s) * t,
              unit(stretch(shape, s, t))};
    case ShapeKind::kDisk: {
      const Vec &n = b, u = across(n);
      const Real angle = 2 * kPi * t;
      return {
          a + (u * std::cos(angle) + cross(n, u) * std::sin(angle)) * (shape.radius * std::sqrt(s)),
          n};
    }
    case ShapeKind::kSphere: {
      const Real z = 2 * s - 1, angle = 2 * kPi * t;
      const Real r = std::sqrt(std::fmax(0, 1 - z * z));
      const Vec n{r * std::cos(angle), r * std::sin(angle), z};
      return {a + n * shape.radius, n};
    }
    case ShapeKind::kCylinder: {
      const Vec &w = b, u = across(w);
      const Real angle = 2 * kPi * t;
      const Vec n = u * std::cos(angle) + cross(w, u) * std::sin(angle);
      return {a + n * shape.radius + w * (shape.half_height * (2 * s - 1)), n};
    }
  }
  return {};
}

SurfacePoint nearest_point(const Shape& shape, const Vec& p) {
  const Vec& middle = shape.at[0];
  if (shape.kind == ShapeKind::kSphere) {
    const Vec out = unit(p - middle);
    return {middle + out * shape.radius, out};
  }
  if (shape.kind == ShapeKind::kCylinder) {
    const Vec& axis = shape.at[1];
    const Real height = dot(p - middle, axis);
    const Vec on_axis = middle + axis * std::clamp(height, -shape.half_height, shape.half_height);
    const Vec out = unit(p - middle - axis * height);
    return {on_axis + out * shape.radius, out};
  }
  const Vec n = normal_of(shape);
  const Real outside = std::fmin(0, inside_by(shape, n, p));
  return {p - n * dot(p - middle, n) - across(n) * outside, n};
}

Real shape_size(const Shape& shape) {
  if (shape.kind == ShapeKind::kCylinder) return std::fmin(shape.radius, shape.half_height);
  if (shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kDisk) return shape.radius;
  const std::vector<Vec> corners = hull(shape);
  Real longest = 0;
  for (const Vec& c : corners) longest = std::fmax(longest, length(c - corners[0]));
  return area_of(shape).first / longest;
}

std::pair<Real, Real> area_of(const Shape& shape) {
  const auto& [a, b, c, d] = shape.at;
  const Real r = shape.radius;
  switch (shape.kind) {
    case ShapeKind::kTriangle:
      return {length(cross(b - a, c - a)) / 2, 0};
    case ShapeKind::kParallelogram:
      return {length(cross(b - a, c - a)), 0};
    case ShapeKind::kDisk:
      return {kPi * r * r, 0};
    case ShapeKind::kSphere:
      return {4 * kPi * r * r, 0};
    case ShapeKind::kCylinder:
      return {4 * kPi * r * shape.half_height, 0};
    case ShapeKind::kPatch: {
      const Real coarse = area_in_cells(shape, 16), fine = area_in_cells(shape, 32);
      return {fine, std::fabs(fine - coarse)};
    }
  }
  return {};
}

}  // namespace lucerna::oracle
