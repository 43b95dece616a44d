// Visibility: batches of segments and rays between points that may lie on surfaces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>

#include "server/estimate/lights/transmittance.h"
#include "server/estimate/queries/queries.h"

namespace lucerna {

/// A ray from a point without a normal starts this many position errors away from the point.
/// Every point of a cube of half edge e lies within sqrt(3) e of its centre.  So a ray that leaves
/// a plane in the cube at more than asin(sqrt(3) / 16) = 6 degrees cannot meet that plane again.
/// With a normal there is no such limit.
inline constexpr float kStartWithoutNormal = 16;

/// The point with its error increased by the error of the surface that it lies on, if there is a
/// surface within both errors.  A surface has the rounding of its vertices, which may lie much
/// farther from zero than the point.  `normal`: unit; if zero, the point is returned unchanged.
ScenePoint on_surface(const Scene& scene, ScenePoint point, const Vec3<float>& normal,
                      double time_s = 0);

/// The ray whose t in (t_min, 1) is the open segment between two points.  `normal`: unit at the
/// start, or zero for none.  No ray if the points are so close that nothing is between them: they
/// see each other.
std::optional<Ray> segment_ray(const ScenePoint& from, const Vec3<float>& normal,
                               const ScenePoint& to);

/// The ray from a point to a sampled point of a light.  `light_reach_m`: LightMotion::reach_m.
Ray light_ray(const ScenePoint& from, const Vec3<float>& normal, const LightSample<double>& to,
              double time_s = 0, float light_reach_m = 0);

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

/// The first surface that `ray` meets, except those that its ends lie on.
std::optional<SurfaceHit> first_other_surface(const Scene& scene, Ray ray, const LooseEnds& ends,
                                              Meets meets = Meets::kSurfaces);

/// Whether `ray` meets a surface that its ends do not lie on.  In most cases one traversal decides.
bool is_blocked(const Scene& scene, const Ray& ray, const LooseEnds& ends, Meets blocking);

}  // namespace lucerna
