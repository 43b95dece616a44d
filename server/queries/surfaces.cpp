#include "server/queries/surfaces.h"

#include <optional>
#include <vector>

#include "server/runtime/bits.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

constexpr std::size_t kGrainOfPlaces = 1024;

/// The ray through a place of the picture; nothing if the place is not on it.
std::optional<Ray> ray_at(const Camera& camera, float x, float y, double time_s) {
  // Written so that NaN is outside.
  const bool inside = x >= 0 && x <= static_cast<float>(camera.width()) && y >= 0 &&
                      y <= static_cast<float>(camera.height());
  if (!inside) return std::nullopt;
  const FilmCrop& crop = camera.crop();
  return camera.ray(static_cast<float>(crop.x0) + x, static_cast<float>(crop.y0) + y, time_s);
}

}  // namespace

WorkCounts find_surfaces(const Scene& scene, const SurfacesQuery& query,
                         const SurfacesAnswer& answer, std::stop_token stop) {
  const std::size_t n = query.size();
  // Bytes, because threads write them in any order.
  std::vector<std::uint8_t> found(n);
  const auto find = [&](std::size_t begin, std::size_t end, WorkCounts& work) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto ray =
          ray_at(scene.camera(), query.places[2 * i], query.places[2 * i + 1], query.time_s);
      answer.status[i] = static_cast<int>(ray ? ItemResult::kOk : ItemResult::kInvalidInput);
      if (!ray) continue;
      ++work.camera_rays;
      const std::optional<SurfaceHit> hit = scene.closest_hit(*ray);
      if (!hit) continue;
      found[i] = 1;
      const bool from_front = dot(hit->ng, Vec3(ray->direction)) <= 0;
      store(answer.offsets_m, i, Vec3f(hit->position));
      store(answer.normals, i, Vec3f(from_front ? hit->ng : -hit->ng));
      if (hit->light >= 0)
        answer.light_ids[i] = scene.lights()[static_cast<std::size_t>(hit->light)].id;
    }
  };
  WorkCounts work = parallel_work(n, kGrainOfPlaces, stop, find);
  work.samples = n;
  for (std::size_t i = 0; i < n; ++i)
    if (found[i] != 0) set_bit(answer.found, i);
  return work;
}

}  // namespace lucerna
