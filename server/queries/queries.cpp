#include "server/queries/queries.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/estimate/wire_direction.h"
#include "server/queries/li_sampler.h"
#include "server/runtime/parallel.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

/// The receiver in the form that lights use; `normal`: unit or zero.
Receiver receiver_of(const ScenePoint& p, const Vec3& normal, AreaSampling way) {
  Receiver r(p.position);
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
  const LightAtTime light(scene.lights()[q.light], q.time_s);
  const auto item = [&](std::size_t i) {
    const ScenePoint p = to_scene(i);
    const Vec3f w = triple(q.wi, i);
    if (!is_direction(w)) return ItemResult::kInvalidInput;
    Vec3 n;
    if (!q.normals.empty()) {
      const Vec3f given = triple(q.normals, i);
      if (!is_direction(given)) return ItemResult::kInvalidInput;
      n = normalized(Vec3(given));
    }
    if (p.result != ItemResult::kOk) return p.result;
    const auto pdf = static_cast<float>(
        light->pdf_li(receiver_of(p, n, q.area_sampling), direction_of(w)).per_sr);
    if (!std::isfinite(pdf)) return ItemResult::kOutOfRange;
    pdf_per_sr[i] = pdf;
    return ItemResult::kOk;
  };
  parallel_chunks(q.receivers.size(), kGrain, stop, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) status[i] = static_cast<int>(item(i));
  });
}

namespace {
// Power does not depend on time, except the power of portals, which depends on the scene's
// sphere.  It is taken at the first key frame.
constexpr double kFirstKeyFrame = -std::numeric_limits<double>::infinity();
}  // namespace

Power light_power(const Scene& scene, std::uint32_t light) {
  return LightAtTime(scene.lights()[light], kFirstKeyFrame)->power(scene.sphere());
}

Power light_power_approximate(const Scene& scene, std::uint32_t light) {
  return LightAtTime(scene.lights()[light], kFirstKeyFrame)->power_approximate(scene.sphere());
}

std::optional<std::uint32_t> hinted_bounces(const Scene& scene) {
  if (!scene.report().hints.max_depth) return std::nullopt;
  return static_cast<std::uint32_t>(std::max(*scene.report().hints.max_depth - 1, 0));
}

}  // namespace lucerna
