#include "server/queries/visibility.h"

#include <cmath>
#include <limits>
#include <vector>

#include "server/rays/coherent_order.h"
#include "server/rays/error_bounds.h"
#include "server/runtime/bits.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

constexpr std::size_t kGrain = 1024;

bool has_normal(const Vec3f& normal) { return normal != Vec3f{}; }

/// The start of a ray: off the surface along `normal`, or at the point, with a later t_min.
Vec3f start_of(const ScenePoint& from, const Vec3f& normal, const Vec3f& direction) {
  if (!has_normal(normal)) return Vec3f(from.position);
  return offset_origin(Vec3f(from.position), {from.error, from.error, from.error}, Vec3(normal),
                       Vec3(direction));
}

/// The ray of item `i`.  Nothing if the item is visible without a ray, or if it has no ray; then
/// `result` has the reason.
std::optional<Ray> ray_of(const Scene& scene, const VisibilityQuery& q, const ToScene& from_scene,
                          const std::optional<ToScene>& to_scene, std::size_t i, ItemResult& result,
                          EndTolerances& ends) {
  ScenePoint from = from_scene(i);
  result = from.result;
  Vec3f normal;
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
  const Vec3f direction = triple(q.directions, i);
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
std::vector<Vec3f> middles_of(const Scene& scene, const VisibilityQuery& q) {
  const auto reach = static_cast<float>(scene.sphere().radius_m);
  const Vec3f shift = q.to ? Vec3f(q.to->origin_m - q.from.origin_m) : Vec3f{};
  std::vector<Vec3f> middles(q.from.size());
  for (std::size_t i = 0; i < middles.size(); ++i) {
    const Vec3f from = triple(q.from.offsets_m, i);
    if (q.to) {
      middles[i] = (from + (triple(q.to->offsets_m, i) + shift)) * 0.5F;
    } else {
      const float length = q.lengths_m.empty() ? reach : std::min(q.lengths_m[i], reach);
      middles[i] = from + normalized(triple(q.directions, i)) * (0.5F * length);
    }
  }
  return middles;
}

}  // namespace

ScenePoint on_surface(const Scene& scene, ScenePoint point, const Vec3f& normal, double time_s) {
  if (!has_normal(normal)) return point;
  const auto largest = static_cast<float>(largest_coordinate(scene));
  const float reach = kStartWithoutNormal * (point.error + kTraversalError * largest);
  Ray ray{Vec3f(point.position + Vec3(normal * reach)), -normal, 0, 2 * reach, time_s};
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

std::optional<Ray> segment_ray(const ScenePoint& from, const Vec3f& normal, const ScenePoint& to) {
  Ray ray;
  ray.origin = start_of(from, normal, Vec3f(to.position - from.position));
  const Vec3 direction = to.position - Vec3(ray.origin);
  const double distance = length(direction);
  if (!(distance > 0)) return std::nullopt;
  ray.direction = Vec3f(direction);
  if (!is_direction(ray.direction)) return std::nullopt;
  if (!has_normal(normal)) {
    ray.t_min = static_cast<float>(kStartWithoutNormal * from.error / distance);
  }
  ray.t_max = static_cast<float>(1 - kStartWithoutNormal * to.error / distance);
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  return ray;
}

Ray light_ray(const ScenePoint& from, const Vec3f& normal, const LightSample& to, double time_s,
              float light_reach_m) {
  SurfaceHit hit;
  hit.position = from.position;
  hit.position_error = {from.error, from.error, from.error};
  hit.ng = hit.ns = Vec3(normal);
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
  const auto test = [&](std::size_t begin, std::size_t end, WorkCounts& spent) {
    const auto put = [&](std::size_t i, const Rgb& share) {
      store(answer.transmittance, i, Vec3f(Vec3(share.r, share.g, share.b)));
    };
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = order.empty() ? k : order[k];
      ItemResult result = ItemResult::kOk;
      EndTolerances ends;
      const std::optional<Ray> ray = ray_of(scene, query, from, to, i, result, ends);
      answer.status[i] = static_cast<int>(result);
      if (result != ItemResult::kOk) continue;
      if (ray) {
        ++spent.shadow_rays;
        if (is_blocked(scene, *ray, ends, transmittance.blocking())) continue;
      }
      visible[i] = 1;
      if (transmittance.is_partial())
        put(i, ray ? transmittance.along(*ray, to ? 1 : ray->t_max, spent) : Rgb(1));
    }
  };
  WorkCounts work = parallel_work(n, kGrain, stop, test);
  for (std::size_t i = 0; i < n; ++i)
    if (visible[i] != 0) set_bit(answer.visible, i);
  work.samples = n;
  return work;
}

}  // namespace lucerna
