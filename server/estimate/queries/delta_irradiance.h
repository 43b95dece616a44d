// Irradiance of scenes in which each light is seen in one direction: one ray for each light, no
// samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>

#include "server/estimate/lights/light_visibility.h"
#include "server/estimate/queries/irradiance.h"

namespace lucerna {

/// Whether reflected light is part of the answer.
inline bool gathers_reflected_light(const Scene& scene, const IrradianceSettings& settings) {
  return settings.bounces.value_or(1) > 0 && !scene.empty() && !scene.lights().empty();
}

/// Immutable except for `result`.  Different threads may call `range` for different ranges at
/// once.
class DeltaIrradiance {
 public:
  /// Fills `result`.  Its arrays must have their sizes and contain zeros.  All arguments must
  /// outlive this object.
  DeltaIrradiance(const Scene& scene, std::span<const IrradiancePoint> points,
                  const IrradianceSettings& settings, const std::stop_token& stop,
                  IrradianceResult& result)
      : scene_(scene),
        points_(points),
        settings_(settings),
        stop_(stop),
        visibility_(scene, settings.methods),
        result_(result) {}

  /// Whether this class returns the whole answer: only direct light, and each light is
  /// visited.
  static bool answers(const Scene& scene, const IrradianceSettings& settings);

  std::size_t points_per_chunk() const;

  /// Computes points [begin, end).  If `stop` is requested, some points may be missing.
  WorkCounts range(std::size_t begin, std::size_t end) const;

 private:
  void settle(std::size_t begin, std::size_t end, WorkCounts& work) const;
  template <typename L>
  void add_light(const L& light, std::uint32_t index, std::size_t begin, std::size_t end,
                 WorkCounts& work) const;
  template <typename MakeRay>
  inline void add(std::uint32_t light, std::size_t point, Rgb lx, bool needs_ray, WorkCounts& work,
                  const MakeRay& ray) const;

  const Scene& scene_;
  std::span<const IrradiancePoint> points_;
  const IrradianceSettings& settings_;
  const std::stop_token& stop_;
  LightVisibility visibility_;
  IrradianceResult& result_;
};

}  // namespace lucerna
