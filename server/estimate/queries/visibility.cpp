#include "server/estimate/queries/visibility.h"

#include <cmath>
#include <limits>
#include <mutex>
#include <vector>

#include "server/estimate/queries/coherent_order.h"
#include "server/rays/error_bounds.h"
#include "server/runtime/bits.h"
#include "server/runtime/denormals.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

constexpr std::size_t kGrain = 1024;

bool has_normal(const Vec3<float>& normal) { return normal != Vec3<float>{}; }

/// The start of a ray: off the surface along `normal`, or at the point, with a later t_min.
Vec3<float> start_of(const ScenePoint& from, const Vec3<float>& normal,
                     const Vec3<float>& direction) {
  if (!has_normal(normal)) return Vec3<float>(from.position);
  return offset_origin(Vec3<float>(from.position), {from.error, from.error, from.error},
                       Vec3<double>(normal), Vec3<double>(direction));
}

/// The ray of item `i`.  Nothing if the item is visible without a ray, or if it has no ray; then
/// `result` has the reason.
std::optional<Ray> ray_of(const Scene& scene, const VisibilityQuery& q, const ToScene& from_scene,
                          const std::optional<ToScene>& to_scene, std::size_t i, ItemResult& result,
                          LooseEnds& ends) {
  ScenePoint from = from_scene(i);
  result = from.result;
  Vec3<float> normal;
  if (!q.normals.empty()) {
    normal = triple(q.normals, i);
    if (!is_finite(normal) || !has_normal(normal)) result = ItemResult::kInvalidInput;
    normal = normalized(normal);
    if (result == ItemResult::kOk && !q.position_error_m)
      from = on_surface(scene, from, normal, q.time_s);
  } else if (!q.position_error_m) {
    ends.start = {from.position, from.error};
  }
  if (to_scene) {
    const ScenePoint to = (*to_scene)(i);
    if (result == ItemResult::kOk) result = to.result;
    if (to.result == ItemResult::kInvalidInput) result = to.result;
    if (result != ItemResult::kOk) return std::nullopt;
    if (!q.position_error_m) ends.end = {to.position, to.error};
    std::optional<Ray> segment = segment_ray(from, normal, to);
    if (segment) segment->time_s = q.time_s;
    return segment;
  }
  const Vec3<float> direction = triple(q.directions, i);
  const float length = q.lengths_m.empty() ? INFINITY : q.lengths_m[i];
  if (!is_direction(direction) || !(length > 0) ||
      (!q.lengths_m.empty() && !std::isfinite(length))) {
    result = ItemResult::kInvalidInput;
  }
  if (result != ItemResult::kOk) return std::nullopt;
  Ray ray{start_of(from, normal, direction), normalized(direction), 0, length};
  ray.time_s = q.time_s;
  if (!has_normal(normal)) ray.t_min = kStartWithoutNormal * from.error;
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  return ray;
}

/// The middles of the rays, about the origin of their starts.  Rays count up to the scene's radius.
/// Only the order of rays depends on them.
std::vector<Vec3<float>> middles_of(const Scene& scene, const VisibilityQuery& q) {
  const auto reach = static_cast<float>(scene.sphere().radius_m);
  const Vec3<float> shift = q.to ? Vec3<float>(q.to->origin_m - q.from.origin_m) : Vec3<float>{};
  std::vector<Vec3<float>> middles(q.from.size());
  for (std::size_t i = 0; i < middles.size(); ++i) {
    const Vec3<float> from = triple(q.from.offsets_m, i);
    if (q.to) {
      middles[i] = (from + (triple(q.to->offsets_m, i) + shift)) * 0.5F;
    } else {
      const float length = q.lengths_m.empty() ? reach : std::min(q.lengths_m[i], reach);
      middles[i] = from + normalized(triple(q.directions, i)) * (0.5F * length);
    }
  }
  return middles;
}

/// A bound on the coordinates of all surfaces, which bounds their rounding.
double largest_coordinate(const Scene& scene) {
  return max_abs(scene.sphere().center_m) + scene.sphere().radius_m;
}

/// The extent of the error of a hit along the surface's normal.
double normal_error_of(const SurfaceHit& hit) {
  return std::fabs(hit.ng.x) * hit.position_error.x + std::fabs(hit.ng.y) * hit.position_error.y +
         std::fabs(hit.ng.z) * hit.position_error.z;
}

/// How far the rounding of its vertices moves a surface along its normal.  The error of a hit is
/// larger: it is that of many roundings.
double rounding_of(const SurfaceHit& hit) {
  const auto across = [](double n, double p) { return std::fabs(n * p); };
  return kFloatRoundoff * (across(hit.ng.x, hit.position.x) + across(hit.ng.y, hit.position.y) +
                           across(hit.ng.z, hit.position.z)) +
         normal_error_of(hit) * (kFloatRoundoff / kTraversalBound);
}

/// Whether the plane of `hit` passes `point` at a distance of at most twice the sum of `error` and
/// its own rounding.
bool plane_passes(const SurfaceHit& hit, const Vec3<double>& point, double error) {
  return std::fabs(dot(hit.ng, hit.position - point)) <= 2 * (error + rounding_of(hit));
}

/// Whether two hits are on one surface: on one shape, or in one plane, such as the floors of two
/// rooms.
bool continues(const SurfaceHit& a, const SurfaceHit& b) {
  return a.shape == b.shape || (plane_passes(a, b.position, rounding_of(b)) &&
                                plane_passes(b, a.position, rounding_of(a)));
}

/// Whether the surface of `hit` is found at `place` too, within `reach` along its normal.
bool is_found_at(const Scene& scene, const Vec3<double>& place, double reach, const LooseEnd& end,
                 const SurfaceHit& hit) {
  // Other surfaces may be equally near, such as a carpet or a sheet of paper.
  constexpr int kMostSurfaces = 16;
  Ray ray{Vec3<float>(place + hit.ng * reach), -Vec3<float>(hit.ng), 0,
          static_cast<float>(2 * reach), hit.time_s};
  for (int i = 0; i < kMostSurfaces; ++i) {
    const auto found = scene.closest_hit(ray);
    if (!found) return false;
    if (plane_passes(*found, end.position, end.error) && continues(*found, hit)) return true;
    ray.t_min = std::nextafter(found->t, INFINITY);
  }
  return false;
}

/// Whether the point lies on the surface that was hit.  The surface's plane must pass the point,
/// and the surface must be found near the point.  A ray that grazes the point's own surface comes
/// within its error long before the end.  A distant shelf in the plane of the point is another
/// surface, even if the point's error is large.
bool lies_on(const Scene& scene, const LooseEnd& end, const SurfaceHit& hit) {
  if (!(end.error >= 0) || !plane_passes(hit, end.position, end.error)) return false;
  const Vec3<double> apart = hit.position - end.position;
  const double near = kStartWithoutNormal * (end.error + max_abs(hit.position_error));
  if (length(apart) <= near) return true;
  // A point at the rim of its surface may be rounded off it.  The direction to the hit leads back.
  const Vec3<double> inwards = normalized(apart) * near;
  return is_found_at(scene, end.position, near, end, hit) ||
         is_found_at(scene, end.position + inwards, near, end, hit);
}

}  // namespace

// An apparent obstacle may be the surface that an end of the ray lies on.  That surface has the
// rounding of its vertices, while a point near zero has almost no error.
std::optional<SurfaceHit> first_other_surface(const Scene& scene, Ray ray, const LooseEnds& ends,
                                              Meets meets) {
  // A ray through a vertex may meet all of its triangles.  Few vertices have more than this.
  constexpr int kMostSurfaces = 16;
  // The step behind a surface at t = 0, relative to the position error and to the scene.  It keeps
  // t above the denormal numbers, which Embree treats as 0.
  constexpr double kStep = 0x1p-10, kLeast = 0x1p-90;
  constexpr float kLeastT = std::numeric_limits<float>::min();
  std::optional<SurfaceHit> hit;
  for (int i = 0; i < kMostSurfaces; ++i) {
    hit = scene.closest_hit(ray, meets);
    if (!hit || (!lies_on(scene, ends.start, *hit) && !lies_on(scene, ends.end, *hit))) return hit;
    const double step_m =
        std::fmax(kStep * max_abs(hit->position_error), kLeast * largest_coordinate(scene));
    ray.t_min = std::fmax(std::fmax(std::nextafter(hit->t, INFINITY), kLeastT),
                          static_cast<float>(step_m / max_abs(ray.direction)));
    if (!(ray.t_min < ray.t_max)) return std::nullopt;
  }
  return hit;
}

ScenePoint on_surface(const Scene& scene, ScenePoint point, const Vec3<float>& normal,
                      double time_s) {
  if (!has_normal(normal)) return point;
  const auto largest = static_cast<float>(largest_coordinate(scene));
  const float reach = kStartWithoutNormal * (point.error + kTraversalError * largest);
  Ray ray{Vec3<float>(point.position + Vec3<double>(normal * reach)), -normal, 0, 2 * reach,
          time_s};
  // Surfaces farther away are others, which the point does not lie on, such as a lamp over it.
  constexpr int kMostSurfaces = 16;
  for (int i = 0; i < kMostSurfaces; ++i) {
    const auto hit = scene.closest_hit(ray);
    if (!hit) break;
    const double away = std::fabs(dot(hit->ng, hit->position - point.position));
    const double error = normal_error_of(*hit);
    if (away <= 2 * (point.error + error)) {
      point.error += static_cast<float>((away + error) * (1 + 1e-6));
      break;
    }
    ray.t_min = std::nextafter(hit->t, INFINITY);
  }
  return point;
}

std::optional<Ray> segment_ray(const ScenePoint& from, const Vec3<float>& normal,
                               const ScenePoint& to) {
  Ray ray;
  ray.origin = start_of(from, normal, Vec3<float>(to.position - from.position));
  const Vec3<double> direction = to.position - Vec3<double>(ray.origin);
  const double distance = length(direction);
  if (!(distance > 0)) return std::nullopt;
  ray.direction = Vec3<float>(direction);
  if (!is_direction(ray.direction)) return std::nullopt;
  if (!has_normal(normal)) {
    ray.t_min = static_cast<float>(kStartWithoutNormal * from.error / distance);
  }
  ray.t_max = static_cast<float>(1 - kStartWithoutNormal * to.error / distance);
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  return ray;
}

Ray light_ray(const ScenePoint& from, const Vec3<float>& normal, const LightSample<double>& to,
              double time_s, float light_reach_m) {
  SurfaceHit hit;
  hit.position = from.position;
  hit.position_error = {from.error, from.error, from.error};
  hit.ng = hit.ns = Vec3<double>(normal);
  hit.time_s = time_s;
  Ray ray = shadow_ray(hit, to, light_reach_m);
  if (!has_normal(normal)) {
    const float distance = length(ray.direction);
    if (distance > 0) {
      ray.t_min = std::fmin(kStartWithoutNormal * from.error / distance, ray.t_max);
    }
  }
  return ray;
}

bool is_blocked(const Scene& scene, const Ray& ray, const LooseEnds& ends, Meets blocking) {
  const Obstacle obstacle = scene.obstacle(ray, ends, blocking);
  return obstacle == Obstacle::kOther ||
         (obstacle == Obstacle::kPerhapsOwn && first_other_surface(scene, ray, ends, blocking));
}

WorkCounts test_visibility(const Scene& scene, const VisibilityQuery& query,
                           const VisibilityAnswer& answer, std::stop_token stop) {
  const ToScene from(scene, query.from, query.position_error_m);
  std::optional<ToScene> to;
  if (query.to) to.emplace(scene, *query.to, query.position_error_m);
  const Transmittance transmittance(scene, query.thin_glass);
  const std::size_t n = query.from.size();
  const std::vector<std::uint32_t> order = coherent_order(middles_of(scene, query));
  // Bytes, because threads write them in any order.
  std::vector<std::uint8_t> visible(n);
  std::mutex mutex;
  WorkCounts work;
  parallel_chunks(n, kGrain, stop, [&](std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    WorkCounts spent;
    const auto put = [&](std::size_t i, const Rgb<double>& share) {
      store(answer.transmittance, i, Vec3<float>(Vec3<double>(share.r, share.g, share.b)));
    };
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = order.empty() ? k : order[k];
      ItemResult result = ItemResult::kOk;
      LooseEnds ends;
      const std::optional<Ray> ray = ray_of(scene, query, from, to, i, result, ends);
      answer.status[i] = static_cast<int>(result);
      if (result != ItemResult::kOk) continue;
      if (ray) {
        ++spent.shadow_rays;
        if (is_blocked(scene, *ray, ends, transmittance.blocking())) continue;
      }
      visible[i] = 1;
      if (transmittance.is_partial())
        put(i, ray ? transmittance.along(*ray, to ? 1 : ray->t_max, spent) : Rgb<double>(1));
    }
    const std::lock_guard lock(mutex);
    work += spent;
  });
  for (std::size_t i = 0; i < n; ++i)
    if (visible[i] != 0) set_bit(answer.visible, i);
  work.samples = n;
  return work;
}

}  // namespace lucerna
