// Visibility: batches of segments and rays between points that may lie on surfaces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>

#include "server/estimate/transmittance.h"
#include "server/queries/queries.h"
#include "server/visibility/end_tolerance.h"

namespace lucerna {

/// The point with its error increased by the error of the surface that it lies on, if there is a
/// surface within both errors.  A surface has the rounding of its vertices, which may lie much
/// farther from zero than the point.  `normal`: unit; if zero, the point is returned unchanged.
ScenePoint on_surface(const Scene& scene, ScenePoint point, const Vec3f& normal, double time_s = 0);

/// The ray whose t in (t_min, 1) is the open segment between two points.  `normal`: unit at the
/// start, or zero for none.  No ray if the points are so close that nothing is between them: they
/// see each other.
std::optional<Ray> segment_ray(const ScenePoint& from, const Vec3f& normal, const ScenePoint& to);

/// The ray from a point to a sampled point of a light.  `light_reach_m`: LightMotion::reach_m.
Ray light_ray(const ScenePoint& from, const Vec3f& normal, const LightSample& to, double time_s = 0,
              float light_reach_m = 0);

struct VisibilityQuery {
  PointArray from;
  std::optional<PointArray> to{};       ///< segments; unset: rays
  std::span<const float> directions{};  ///< three for each ray, any length except 0
  std::span<const float> lengths_m{};   ///< above 0; empty: infinite
  std::span<const float> normals{};     ///< three for each item, or empty
  std::optional<float> position_error_m{};
  double time_s = 0;
  ThinGlass thin_glass = ThinGlass::kPasses;
};

/// Arrays to fill, with one entry for each item.  All start as zeros.
struct VisibilityAnswer {
  std::uint8_t* visible;  ///< bits: whether no surface blocks the way
  /// The share of light that arrives, three channels for each item.  Null if
  /// Transmittance::is_partial() is false.
  float* transmittance;
  int* status;  ///< ItemResult
};

/// kInvalidInput if a length is not above 0.  A segment of length 0 is visible.
WorkCounts test_visibility(const Scene& scene, const VisibilityQuery& query,
                           const VisibilityAnswer& answer, std::stop_token stop);

}  // namespace lucerna
