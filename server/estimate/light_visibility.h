// How much of a light is visible: by a ray, or by the light's shadow map if it has one.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "lights/sampling/sobol.h"
#include "server/estimate/methods.h"
#include "server/estimate/transmittance.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"
#include "server/visibility/lamp_contacts.h"
#include "server/visibility/shadow_maps.h"

namespace lucerna {

/// Immutable; may be called from any thread.
class LightVisibility {
 public:
  /// `scene` must outlive this object.
  LightVisibility(const Scene& scene, const Methods& methods)
      : scene_(scene), transmittance_(scene, methods.thin_glass), contacts_(lamp_contacts(scene)) {
    // Maps know only whether light arrives.
    if (methods.visibility == VisibilityMethod::kShadowMaps && !transmittance_.is_partial())
      maps_ = &shadow_maps(scene);
  }
  /// `maps` belong to the lights of the scene.  Both must outlive this object.
  LightVisibility(const Scene& scene, const ShadowMaps* maps)
      : scene_(scene),
        transmittance_(scene, ThinGlass::kBlocks),
        contacts_(lamp_contacts(scene)),
        maps_(maps) {}

  const Transmittance& transmittance() const { return transmittance_; }

  /// The share of light, by channel, that arrives at a position from the light, by map or by ray.
  /// `normal`: of the surface, unit, or zero.  `ray`: from the surface to the light.
  Rgb visible(std::uint32_t light, const Vec3& position, const Vec3& normal, const Ray& ray,
              WorkCounts& work) const {
    if (const auto occluded = by_map(light, position, normal)) {
      ++work.map_lookups;
      if (is_compared(ray)) {
        ++work.shadow_rays;
        compare(*occluded, scene_.geometry().occluded(ray), work);
      }
      return Rgb(*occluded ? 0 : 1);
    }
    ++work.shadow_rays;
    const RayFilter blocking = transmittance_.blocking();
    if (contacts_.touches(light) ? contacts_.is_hidden(light, position, ray, blocking)
                                 : scene_.geometry().occluded(ray, blocking))
      return {};
    return transmittance_.is_partial() ? passed(light, position, ray, work) : Rgb(1);
  }
  /// The share of light that panes and media pass along a ray to the light that no surface blocks.
  /// `error_m`: as for LampContacts::is_hidden.
  Rgb passed(std::uint32_t light, const Vec3& position, const Ray& ray, WorkCounts& work,
             float error_m = 0) const {
    if (!transmittance_.through_panes() || !contacts_.touches(light)) [[likely]]
      return transmittance_.along(ray, work);
    return transmittance_.along(ray, ray.t_max,
                                contacts_.through_panes(light, position, ray, error_m), work);
  }

  /// Whether the light's map has an obstacle before a position.  Nothing if there is no map or the
  /// position is outside of it: then a ray is needed.
  std::optional<bool> by_map(std::uint32_t light, const Vec3& position, const Vec3& normal) const {
    if (maps_ == nullptr || contacts_.touches(light)) return std::nullopt;
    const ShadowMap* map = maps_->map(light);
    return map == nullptr ? std::nullopt : map->is_occluded(position, normal);
  }

  const LampContacts& contacts() const { return contacts_; }

  /// One look-up in this many is compared with a ray.  A picture then has hundreds of comparisons,
  /// and their rays add about 1% to the time.
  static constexpr std::uint64_t kComparedOneIn = 64;
  /// Whether to compare the look-up with a ray.  The bits of the ray decide, so that counts depend
  /// only on the query.
  static bool is_compared(const Ray& ray) {
    const auto both = [](float a, float b) {
      return std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32 | std::bit_cast<std::uint32_t>(b);
    };
    const Vec3f &o = ray.origin, &d = ray.direction;
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
  Transmittance transmittance_;
  const LampContacts& contacts_;
  const ShadowMaps* maps_ = nullptr;  ///< null: rays only
};

}  // namespace lucerna
