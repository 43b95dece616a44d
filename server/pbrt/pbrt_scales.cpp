#include "server/pbrt/pbrt_scales.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "server/pbrt/pbrt_levels.h"

namespace lucerna::pbrt {
namespace {

/// The scale factors of a transform along three perpendicular directions, ascending: the singular
/// values of its linear part.  [Golub13]
std::array<double, 3> scales_of(const Transform& transform) {
  const Transform::Matrix& m = transform.matrix();
  // Normalises the largest entry to 1, so that no square overflows or underflows.
  double largest = 0;
  for (const auto& row : m)
    for (int j = 0; j < 3; ++j) largest = std::fmax(largest, std::fabs(row[j]));
  std::array<Vec3, 3> columns;
  for (int j = 0; j < 3; ++j) columns[j] = Vec3{m[0][j], m[1][j], m[2][j]} / largest;
  // One-sided Jacobi: rotates two columns at a time until all are perpendicular.
  constexpr int kSweeps = 16;  // convergence is quadratic
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      const Vec3 a = columns[p], b = columns[q];
      const double product = dot(a, b);
      if (product == 0) continue;
      const double zeta = (dot(b, b) - dot(a, a)) / (2 * product);
      const double tangent = std::copysign(1 / (std::fabs(zeta) + std::hypot(1, zeta)), zeta);
      const double cosine = 1 / std::hypot(1, tangent), sine = cosine * tangent;
      columns[p] = a * cosine - b * sine;
      columns[q] = a * sine + b * cosine;
    }
  std::array<double, 3> scales;
  for (int j = 0; j < 3; ++j) scales[j] = largest * length(columns[j]);
  std::ranges::sort(scales);
  return scales;
}

}  // namespace

std::string scales_text(const Transform& transform) {
  // As many digits as Transform::uniform_scale distinguishes.
  const std::array<double, 3> s = scales_of(transform);
  return fmt::format("scales {:.8g}, {:.8g} and {:.8g}", s[0], s[1], s[2]);
}

std::shared_ptr<const Frame> own_space_of(LoadState& context, const ParameterSet& params,
                                          const Transform& world_from_light) {
  if (world_from_light.uniform_scale()) return nullptr;
  if (const Parameter* power = positive_parameter(params, "power"))
    context.remark(power->place, "\"power\" of a light under a transform of unequal scale",
                   "the same intensity as in pbrt-v4, which leaves out the transform");
  return std::make_shared<const Frame>(axes_of(world_from_light));
}

void require_equal_scale(const FilePosition& place, std::string_view what,
                         const Transform& transform) {
  if (!transform.uniform_scale())
    fail(place, fmt::format("{} under a transform of unequal {}, allowed: equal scale on all axes",
                            what, scales_text(transform)));
}

}  // namespace lucerna::pbrt
