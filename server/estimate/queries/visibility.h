// Whether anything stands between: batches of segments and rays between points that may lie on
// surfaces.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>

#include "server/estimate/queries/queries.h"

namespace lucerna {

/// A ray from a point that has no normal begins this many position errors away from it.  Every
/// point of a cube of half edge e lies within sqrt(3) e of its centre; so a ray that leaves a plane
/// within the cube at an angle of more than asin(sqrt(3) / 16) = 6 degrees cannot meet that plane
/// again. With a normal there is no such limit.
inline constexpr float kStartWithoutNormal = 16;

/// The point with its error widened by that of the surface that it lies on, as far as there is one
/// within both errors: a surface is rounded with its vertices, which may lie much farther from zero
/// than the point.  `normal`: unit, or zero: then nothing is changed.
ScenePoint on_surface(const Scene& scene, ScenePoint point, const Vec3<float>& normal,
                      double time_s = 0);

/// The ray whose t in (t_min, 1) is the open way between two points; `normal`: unit at the start,
/// or zero for none.  Nothing where the points are so close that nothing is left between them: they
/// see each other.
std::optional<Ray> segment_ray(const ScenePoint& from, const Vec3<float>& normal,
                               const ScenePoint& to);

/// The way from a point to a sampled point of a light.  `light_reach_m`: LightMotion::reach_m.
Ray light_ray(const ScenePoint& from, const Vec3<float>& normal, const LightSample<double>& to,
              double time_s = 0, float light_reach_m = 0);

struct VisibilityQuery {
  PointArray from;
  std::optional<PointArray> to{};       ///< segments; else rays:
  std::span<const float> directions{};  ///< three a ray, of any length but 0
  std::span<const float> lengths_m{};   ///< > 0, or none: infinitely far
  std::span<const float> normals{};     ///< three an item, or none
  std::optional<float> position_error_m{};
  double time_s = 0;
};

/// Sets bit i of `visible` (zeros before) where nothing stands between; `status` is an ItemResult
/// for each.  A length that is not above 0 is kInvalidInput.  A segment of no length is visible.
WorkCounts test_visibility(const Scene& scene, const VisibilityQuery& query, std::uint8_t* visible,
                           int* status, std::stop_token stop);

/// The end of a ray at a point that may lie on a surface whose normal nobody told.
struct LooseEnd {
  Vec3<double> position;
  float error = -1;  ///< below 0: this end asks for nothing
};

struct LooseEnds {
  LooseEnd start, end;
};

/// The first surface that `ray` meets, other than those that its ends lie on.
std::optional<SurfaceHit> first_other_surface(const Scene& scene, Ray ray, const LooseEnds& ends);

/// Sets the bits (numbered by `items`) of those rays that meet nothing but the surfaces that their
/// ends lie on; `ends` holds as many as `rays`.
void mark_visible(const Scene& scene, std::span<const Ray> rays, std::span<const LooseEnds> ends,
                  std::span<const std::uint32_t> items, std::uint8_t* visible);

}  // namespace lucerna
