#include "server/estimate/queries/queries.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/estimate/lights/told_direction.h"
#include "server/estimate/queries/li_sampler.h"
#include "server/runtime/denormals.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

/// What a light is told; `normal`: unit or zero.
Receiver<double> receiver_of(const ScenePoint& p, const Vec3<double>& normal, AreaSampling way) {
  Receiver<double> r(p.position);
  r.normal = normal;
  r.area_sampling = way;
  return r;
}

}  // namespace

ToScene::ToScene(const Scene& scene, const PointArray& points,
                 std::optional<float> position_error_m)
    : offsets_m_(points.offsets_m),
      shift_m_(points.origin_m - scene.origin()),
      origin_error_m_(kDefaultUlps * std::numeric_limits<double>::epsilon() *
                      max_abs(points.origin_m)),
      position_error_m_(position_error_m) {}

void put_choice(const Scene& scene, const std::optional<LightChoice>& choice, std::size_t i,
                std::uint64_t* light_ids, double* selection_probability) {
  selection_probability[i] = choice ? choice->probability : 1;
  if (choice) light_ids[i] = scene.lights()[choice->light].id;
}

WorkCounts sample_li(const Scene& scene, const SampleLiQuery& query, const SampleLiAnswer& answer,
                     std::stop_token stop) {
  const LiLayout layout(query.receivers.size(), query.samples);
  return fill_samples(LiSampler(scene, query), layout, answer, {}, stop);
}

void pdf_li(const Scene& scene, const PdfLiQuery& q, float* pdf_per_sr, int* status,
            std::stop_token stop) {
  constexpr std::size_t kGrain = 512;
  const ToScene to_scene(scene, q.receivers, 0.0F);
  visit_light(scene.lights()[q.light], q.time_s, [&](const auto& l) {
    parallel_chunks(q.receivers.size(), kGrain, stop, [&](std::size_t begin, std::size_t end) {
      const DenormalsAreZero denormals;
      for (std::size_t i = begin; i < end; ++i) {
        const ScenePoint p = to_scene(i);
        const Vec3<float> w = triple(q.wi, i);
        ItemResult result = p.result;
        if (!is_direction(w)) result = ItemResult::kInvalidInput;
        Vec3<double> n;
        if (!q.normals.empty()) {
          const Vec3<float> given = triple(q.normals, i);
          if (!is_direction(given)) result = ItemResult::kInvalidInput;
          n = normalized(Vec3<double>(given));
        }
        if (result == ItemResult::kOk) {
          const auto pdf = static_cast<float>(
              l.pdf_li(receiver_of(p, n, q.area_sampling), direction_of(w)).per_sr);
          if (std::isfinite(pdf)) {
            pdf_per_sr[i] = pdf;
          } else {
            result = ItemResult::kOutOfRange;
          }
        }
        status[i] = static_cast<int>(result);
      }
    });
  });
}

Power light_power(const Scene& scene, std::uint32_t light) {
  // The same at any time, but for what the scene's sphere is to portals: at the first key frame.
  return visit_light(scene.lights()[light], -std::numeric_limits<double>::infinity(),
                     [&](const auto& l) { return l.power(scene.sphere()); });
}

Power light_power_approximate(const Scene& scene, std::uint32_t light) {
  return visit_light(scene.lights()[light], -std::numeric_limits<double>::infinity(),
                     [&](const auto& l) { return l.power_approximate(scene.sphere()); });
}

std::optional<std::uint32_t> hinted_bounces(const Scene& scene) {
  if (!scene.hints().max_depth) return std::nullopt;
  return static_cast<std::uint32_t>(std::max(*scene.hints().max_depth - 1, 0));
}

}  // namespace lucerna
