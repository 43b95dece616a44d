// Irradiance of scenes whose lights are all seen in one direction: a ray each, and no samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>

#include "server/estimate/lights/light_visibility.h"
#include "server/estimate/paths/render.h"

namespace lucerna {

/// Whether reflected light is part of the answer.
inline bool gathers_reflected_light(const Scene& scene, const IrradianceSettings& settings) {
  return settings.bounces.value_or(1) > 0 && !scene.empty() && !scene.lights().empty();
}

/// Immutable but for the answers; ranges may be asked for on several threads at once.
class DeltaIrradiance {
 public:
  /// Fills `result`, whose arrays have their sizes and are zeros; all outlive it.
  DeltaIrradiance(const Scene& scene, std::span<const IrradiancePoint> points,
                  const IrradianceSettings& settings, const std::stop_token& stop,
                  IrradianceResult& result)
      : scene_(scene),
        points_(points),
        settings_(settings),
        stop_(stop),
        visibility_(scene, settings.methods.visibility),
        result_(result) {}

  /// Whether that is all: direct light alone, and each light is asked.
  static bool answers(const Scene& scene, const IrradianceSettings& settings);

  std::size_t points_per_chunk() const;

  /// Answers points [begin, end); where `stop` is asked for, not all of them.
  WorkCounts range(std::size_t begin, std::size_t end) const;

 private:
  void settle(std::size_t begin, std::size_t end, WorkCounts& work) const;
  template <typename L>
  void add_light(const L& light, std::uint32_t index, std::size_t begin, std::size_t end,
                 WorkCounts& work) const;
  template <typename MakeRay>
  inline void add(std::uint32_t light, std::size_t point, const Rgb<double>& lx, bool needs_ray,
                  WorkCounts& work, const MakeRay& ray) const;

  const Scene& scene_;
  std::span<const IrradiancePoint> points_;
  const IrradianceSettings& settings_;
  const std::stop_token& stop_;
  LightVisibility visibility_;
  IrradianceResult& result_;
};

}  // namespace lucerna
