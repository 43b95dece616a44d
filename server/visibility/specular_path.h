// Paths of light between two points by way of given mirrors, panes and glass.
//
// By Fermat's principle, light takes a path at which every surface sends it on by the law of
// reflection or refraction.  Such a path is one direction at its start.  By planes and outsides of
// balls there is at most one path for one sequence of surfaces, because no surface focuses light.
// Newton's method finds it: differentials of the ray give the exact derivatives.  [Jakob12],
// [Igehy99]
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "lights/maths/vec.h"
#include "server/visibility/smooth_surfaces.h"

namespace lucerna {

/// What a path does at one surface.
struct SmoothStep {
  const SmoothPart* part = nullptr;
  bool passes = false;  ///< refracted or straight on; else reflected
};

/// The most surfaces of one path.
inline constexpr std::size_t kMostSteps = 32;

struct SpecularPath {
  std::array<Vec3, kMostSteps> points;  ///< on the surfaces, in order from the start
  Vec3 start;                           ///< unit, from the start to points[0]
  Vec3 end;                             ///< unit, along the last leg to the target
  /// Solid angle at the start of the rays to a unit of area around the target, across the last leg
  /// [sr/m2].  For a direction as the target: the same for a unit of its solid angle.
  double spread = 0;
};

/// The path from `from` by `steps` to the point `to`.  Nothing if there is none: the surfaces are
/// taken as whole planes, of which a path must pass the rectangles.
std::optional<SpecularPath> path_to_point(const Vec3& from, std::span<const SmoothStep> steps,
                                          const Vec3& to);
/// The path whose last leg has the direction `w`, unit.
std::optional<SpecularPath> path_to_direction(const Vec3& from, std::span<const SmoothStep> steps,
                                              const Vec3& w);

/// `p` mirrored by a plane.
inline Vec3 mirror_image(const SmoothPart& plane, const Vec3& p) {
  return p - plane.n * (2 * plane.height(p));
}
/// The vector `v` mirrored by a plane.
inline Vec3 mirror_vector(const SmoothPart& plane, const Vec3& v) {
  return v - plane.n * (2 * dot(plane.n, v));
}

}  // namespace lucerna
