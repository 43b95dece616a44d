// The luminous flux of sources.
#include "tests/oracle/oracle_lights.h"
#include "tests/oracle/oracle_shapes.h"
#include "tests/oracle/oracle_truth.h"

namespace lucerna::oracle {

std::optional<Amount> Truth::power(int source) const {
  const int lights = static_cast<int>(world_.lights.size());
  if (source < lights) {
    const Light& light = world_.lights[static_cast<std::size_t>(source)];
    switch (light.kind) {
      case LightKind::kDistant:
      case LightKind::kSun:
      case LightKind::kSky:
      case LightKind::kPortal:
        return std::nullopt;
      default:
        break;
    }
    const Real value = flux(light);
    return Amount{value, 1e-12L * value};
  }
  const int number = emitting_shapes(world_)[static_cast<std::size_t>(source - lights)];
  const Shape& shape = world_.shapes[static_cast<std::size_t>(number)];
  const auto [area, error] = area_of(shape);
  Real level = kPi * shape.radiance * (shape.two_sided ? 2 : 1);
  if (!shape.picture.empty()) {
    Real sum = 0;
    for (const Real x : shape.picture.values) sum += x;
    level *= sum / static_cast<Real>(shape.picture.values.size());
  }
  // Corners are rounded: a sliver's width may change by that.
  Real wide = 0;
  const std::vector<Vec> corners = hull(shape);
  for (const Vec& p : corners) wide = std::fmax(wide, length(p - corners[0]));
  const Real slack = is_flat(shape) || is_curved(shape) ? 4 * wide * length(rounding(shape)) : 0;
  return Amount{level * area, level * (error + slack + 1e-12L * area)};
}

}  // namespace lucerna::oracle
