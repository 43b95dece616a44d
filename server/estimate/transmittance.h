// The share of direct light that panes and media let pass.
#pragma once

#include "server/estimate/methods.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Immutable; may be called from any thread.
class Transmittance {
 public:
  Transmittance(const Scene& scene, ThinGlass thin_glass)
      : scene_(scene),
        through_panes_(scene.geometry().has_panes() && thin_glass == ThinGlass::kPasses),
        is_partial_(through_panes_ || scene.geometry().has_media()) {}

  bool through_panes() const { return through_panes_; }
  /// Whether light may arrive in part.  Otherwise all of it arrives or none.
  bool is_partial() const { return is_partial_; }
  /// The surfaces that block direct light.
  RayFilter blocking() const { return through_panes_ ? RayFilter::kOpaque : RayFilter::kSurfaces; }
  /// The surfaces that rays meet when they search for lights or for the next surface.
  RayFilter met() const {
    return through_panes_ ? RayFilter::kPanesByChance : RayFilter::kSurfaces;
  }

  /// The share of light, by channel, that passes along a ray that no surface blocks.
  Rgb along(const Ray& ray, WorkCounts& work) const { return along(ray, ray.t_max, work); }
  /// The same if the way ends at `t_end`, later than the ray.  Rays start and end beside the
  /// surfaces that their ends may lie on.  Media fill the whole way.
  Rgb along(const Ray& ray, float t_end, WorkCounts& work) const {
    return along(ray, t_end, through_panes_ ? scene_.geometry().through_panes(ray) : 1, work);
  }
  /// The same if all panes together pass `of_panes` of the light.  1 unless panes pass light.
  Rgb along(const Ray& ray, float t_end, double of_panes, WorkCounts& work) const {
    Ray way = ray;
    way.t_min = 0;
    way.t_max = t_end;
    if (of_panes < 1) ++work.through_panes;
    return scene_.geometry().through_media(way) * of_panes;
  }

 private:
  const Scene& scene_;
  bool through_panes_, is_partial_;
};

}  // namespace lucerna
