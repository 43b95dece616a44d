#include "server/estimate/queries/delta_irradiance.h"

#include <algorithm>
#include <chrono>
#include <numbers>

#include "server/estimate/lights/direct_light.h"
#include "server/estimate/queries/irradiance_estimate.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
namespace {

// A chunk takes 0.1 to 8 ms; a light takes 0.01 to 1 us.
constexpr std::size_t kLightsPerChunk = 8192;
// Number of points in a row for each light, because finding the model of a light takes as long as
// one sample.  This number fits the processor's first-level cache.
constexpr std::size_t kAtOnce = 64;

/// Irradiance of light from `wi`.  Computed from reflected radiance, as for samples, so that both
/// have the same bits.
Rgb lux_from(const Vec3& wi, const Rgb& value, const Vec3& normal) {
  const double cosine = dot(normal, wi);
  if (!(cosine > 0)) return {};
  return value * (cosine * std::numbers::inv_pi) * std::numbers::pi;
}

}  // namespace

bool DeltaIrradiance::answers(const Scene& scene, const IrradianceSettings& settings) {
  return !gathers_reflected_light(scene, settings) && settings.wavelengths_nm.empty() &&
         DirectLight(scene, settings.methods).settles_all();
}

std::size_t DeltaIrradiance::points_per_chunk() const {
  return std::max<std::size_t>(1,
                               kLightsPerChunk / std::max<std::size_t>(1, scene_.lights().size()));
}

WorkCounts DeltaIrradiance::range(std::size_t begin, std::size_t end) const {
  WorkCounts work;
  for (std::size_t p = begin; p < end && !stop_.stop_requested(); p += kAtOnce)
    settle(p, std::min(p + kAtOnce, end), work);
  return work;
}

void DeltaIrradiance::settle(std::size_t begin, std::size_t end, WorkCounts& work) const {
  std::chrono::steady_clock::time_point start;
  if (settings_.target) start = std::chrono::steady_clock::now();
  const auto lights = static_cast<std::uint32_t>(scene_.lights().size());
  for (std::uint32_t l = 0; l < lights; ++l)
    with_fast_light(scene_.lights()[l], settings_.time_s,
                    [&](const auto& light) { add_light(light, l, begin, end, work); });
  for (std::size_t p = begin; p < end; ++p)
    set_exact(result_.points[p].irradiance_lx, result_.points[p]);
  if (settings_.per_light)
    for (std::size_t s = begin * lights; s < end * lights; ++s)
      set_exact(result_.per_light[s].irradiance_lx, result_.per_light[s]);
  if (settings_.target) {
    // Each point gets an equal part of the time.  The time is measured only with a target.
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    for (std::size_t p = begin; p < end; ++p)
      result_.costs[p].time_s = took.count() / static_cast<double>(end - begin);
  }
}

/// Adds light unless something is in its way.  Calls `ray()` only if a ray is needed.
template <typename MakeRay>
[[gnu::always_inline]] inline void DeltaIrradiance::add(std::uint32_t light, std::size_t p, Rgb lx,
                                                        bool needs_ray, WorkCounts& work,
                                                        const MakeRay& ray) const {
  if (lx.is_black()) return;
  if (needs_ray) {
    const std::uint64_t rays = work.shadow_rays;
    lx = lx * visibility_.visible(light, points_[p].position, Vec3(points_[p].normal), ray(), work);
    result_.costs[p].rays += work.shadow_rays - rays;
  }
  result_.points[p].irradiance_lx += lx;
  if (settings_.per_light) result_.per_light[p * scene_.lights().size() + light].irradiance_lx = lx;
}

template <typename L>
void DeltaIrradiance::add_light(const L& light, std::uint32_t index, std::size_t begin,
                                std::size_t end, WorkCounts& work) const {
  const bool needs_rays = !scene_.is_clear();
  const float reach_m = scene_.lights()[index].reach_m();
  for (std::size_t p = begin; p < end; ++p) {
    const IrradiancePoint& point = points_[p];
    if constexpr (std::is_same_v<L, PointLight>) {
      if (const auto s = light.plain_sample_li(point.position)) [[likely]] {
        add(index, p, lux_from(s->wi, s->value, point.normal), needs_rays, work, [&] {
          return ray_to_point(surface_at(point, settings_.time_s), s->wi, Vec3f(light.position()));
        });
        continue;
      }
    }
    Receiver receiver(point.position);
    receiver.normal = point.normal;
    const LightSample s = light.sample_li(receiver, {});
    add(index, p, lux_from(s.wi, s.value, receiver.normal), needs_rays, work,
        [&] { return shadow_ray(surface_at(point, settings_.time_s), s, reach_m); });
  }
}

}  // namespace lucerna
