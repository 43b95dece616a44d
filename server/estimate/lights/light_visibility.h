// Whether a light is visible, in the way that was asked for: by a ray, or by the light's shadow map
// where it has one.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "lights/sampling/sobol.h"
#include "server/estimate/lights/methods.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"
#include "server/shadows/shadow_maps.h"

namespace lucerna {

/// Immutable; one may serve any number of threads.
class LightVisibility {
 public:
  LightVisibility(const Scene& scene, VisibilityMethod method)
      : LightVisibility(scene,
                        method == VisibilityMethod::kShadowMaps ? &shadow_maps(scene) : nullptr) {}
  /// `maps`: of the same lights; null: rays alone.  Both outlive it.
  LightVisibility(const Scene& scene, const ShadowMaps* maps) : scene_(scene), maps_(maps) {}

  /// What the light's map says of a position on a surface.  Nothing where it has none, or does not
  /// look there: then a ray must tell.  `normal`: of the surface, unit, or zero.
  std::optional<bool> by_map(std::uint32_t light, const Vec3<double>& position,
                             const Vec3<double>& normal) const {
    if (maps_ == nullptr) return std::nullopt;
    const ShadowMap* map = maps_->map(light);
    return map == nullptr ? std::nullopt : map->is_occluded(position, normal);
  }

  /// The same by whatever tells it; `ray`: the way from the surface to the light.
  bool is_occluded(std::uint32_t light, const Vec3<double>& position, const Vec3<double>& normal,
                   const Ray& ray, WorkCounts& work) const {
    const auto told = by_map(light, position, normal);
    if (!told) {
      ++work.shadow_rays;
      return scene_.occluded(ray);
    }
    ++work.map_lookups;
    if (is_compared(ray)) {
      ++work.shadow_rays;
      compare(*told, scene_.occluded(ray), work);
    }
    return *told;
  }

  /// One in as many look-ups is compared: enough that a picture has hundreds, while their rays add
  /// some hundredth to the time.
  static constexpr std::uint64_t kComparedOneIn = 64;
  /// Whether a ray is to be traced beside the look-up: by the bits of the ray, so that which they
  /// are, and with them the counts, is a function of the question alone.
  static bool is_compared(const Ray& ray) {
    const auto both = [](float a, float b) {
      return std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32 | std::bit_cast<std::uint32_t>(b);
    };
    const Vec3<float>&o = ray.origin, &d = ray.direction;
    const std::uint64_t bits =
        mix_bits(mix_bits(mix_bits(both(o.x, o.y)) + both(o.z, d.x)) + both(d.y, d.z));
    return bits % kComparedOneIn == 0;
  }

  static void compare(bool by_map, bool by_ray, WorkCounts& work) {
    ++work.map_compared;
    if (by_map != by_ray) ++work.map_disagreed;
  }

 private:
  const Scene& scene_;
  const ShadowMaps* maps_;
};

}  // namespace lucerna
