#include "server/emission_queries.h"

#include "server/denormals.h"
#include "server/parallel.h"
#include "server/path.h"
#include "server/visibility.h"

namespace lucerna {
namespace {

constexpr std::size_t kGrain = 512;

}  // namespace

WorkCounts le(const Scene& scene, const LeQuery& query, const LeAnswer& answer,
              std::stop_token stop) {
  const ToScene to_scene(scene, query.points, std::nullopt);
  const PathTracer tracer(scene, 0);
  std::atomic<std::uint64_t> rays = 0;
  parallel_chunks(query.points.size(), kGrain, stop, [&](std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    std::uint64_t chunk_rays = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const ScenePoint p = to_scene(i);
      const Vec3<float> direction = triple(query.directions, i);
      ItemResult result = p.result;
      if (!is_finite(direction) || direction == Vec3<float>{}) result = ItemResult::kInvalidInput;
      if (result == ItemResult::kOk) {
        Ray ray{p.position, normalized(direction), kStartWithoutNormal * p.error};
        ray.time_s = query.time_s;
        const auto hit = first_other_surface(scene, ray, {{p.position, p.error}, {}});
        ++chunk_rays;
        Rgb<float> sum;
        std::uint64_t met = 0;
        tracer.for_each_emitter(ray, hit, [&](std::uint32_t light, const Rgb<float>& radiance) {
          if (query.light && light != *query.light) return;
          if (met == 0) met = scene.lights()[light].id;
          sum += radiance;
        });
        if (is_finite(sum)) {
          answer.light_ids[i] = met;
          answer.radiance_cd_m2[3 * i] = sum.r;
          answer.radiance_cd_m2[3 * i + 1] = sum.g;
          answer.radiance_cd_m2[3 * i + 2] = sum.b;
        } else {
          result = ItemResult::kOutOfRange;
        }
      }
      answer.status[i] = static_cast<int>(result);
    }
    rays += chunk_rays;
  });
  WorkCounts work;
  work.samples = query.points.size();
  work.indirect_rays = rays;
  return work;
}

}  // namespace lucerna
