#include "lights/maths/deformation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/maths/validation.h"

namespace lucerna {
namespace {

Transform::Matrix columns(const Vec3& x, const Vec3& y, const Vec3& z) {
  return {{{x.x, y.x, z.x, 0}, {x.y, y.y, z.y, 0}, {x.z, y.z, z.z, 0}}};
}

/// The root of the sum of all squares, which bounds the length of a mapped unit vector.
double norm(const Transform& t) {
  double sum = 0;
  for (const auto& row : t.matrix())
    for (int j = 0; j < 3; ++j) sum += row[j] * row[j];
  return std::sqrt(sum);
}

absl::Status flat() {
  return absl::InvalidArgumentError(
      "light.own_space has axes in one plane, nearly, allowed: a transform with an inverse");
}

}  // namespace

absl::StatusOr<Deformation> Deformation::create(const Frame& axes) {
  for (const Vec3& axis : {axes.s, axes.t, axes.n})
    if (auto s = check_direction("light.own_space", axis); !s.ok()) return s;
  // Only ratios of lengths matter.
  const int exponent = -std::ilogb(std::max({max_abs(axes.s), max_abs(axes.t), max_abs(axes.n)}));
  const auto map = Transform::from_matrix(
      columns(scaled(axes.s, exponent), scaled(axes.t, exponent), scaled(axes.n, exponent)));
  if (!map) return flat();
  const Deformation made(*map);
  if (std::isfinite(made.determinant_) && std::isfinite(made.most_shrinking_)) return made;
  return flat();
}

Deformation::Deformation(const Transform& map)
    : map_(map), inverse_(map.inverse()), stretch_(norm(map) * norm(inverse_)) {
  const Vec3 x = inverse_.vector({1, 0, 0}), y = inverse_.vector({0, 1, 0}),
             z = inverse_.vector({0, 0, 1});
  determinant_ = std::fabs(dot(cross(x, y), z));
  most_shrinking_ = std::pow(norm(inverse_), 3) / determinant_;
}

double Deformation::own_sr_per_world_sr(const Vec3& w) const {
  const double length_own = length(own_from_world(w));
  return determinant_ / (length_own * length_own * length_own);
}

// The edge of the cone becomes an elliptical cone.  The angle of its directions to the axis changes
// at most by `step` between two of the tested ones.
EmissionCone Deformation::world_cone(const EmissionCone& own) const {
  EmissionCone all{own.axis, std::numbers::pi};
  constexpr double kWide = std::numbers::pi / 2 - 1e-3;  // a cone that is not convex, or nearly
  if (own.half_angle_rad > kWide) return all;
  constexpr int kDirections = 256;
  const Vec3 axis = normalized(world_from_own(own.axis));
  const auto frame = Frame::around(own.axis);
  const double sine = std::sin(own.half_angle_rad), cosine = std::cos(own.half_angle_rad);
  double widest = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double phi = 2 * std::numbers::pi * i / kDirections;
    const Vec3 w = normalized(world_from_own(
        frame.world_from_local({sine * std::cos(phi), sine * std::sin(phi), cosine})));
    widest = std::max(widest, std::atan2(length(cross(axis, w)), dot(axis, w)));
  }
  const double step = std::numbers::pi / kDirections * stretch_ * sine + 1e-12;
  if (!(widest + step < std::numbers::pi)) return all;
  return {axis, widest + step};
}

}  // namespace lucerna
