// Decides whether the answer at a receiver may miss light.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "proto/common/confidence.h"
#include "server/scene/scene.h"
#include "server/visibility/smooth_surfaces.h"

namespace lucerna {

/// Light that may be missing from an answer, because samples cannot find it or found none.
struct MissedLight {
  enum class Kind : std::uint8_t {
    kNone,
    kByWay,      ///< of lamps, by way of smooth surfaces for which paths are not computed
    kReflected,  ///< by rough surfaces
    kOutdoors,   ///< of a sky that shines only through a portal
  };
  Kind kind = Kind::kNone;
  double bound_lx = 0;  ///< 0: none is known
};

/// The lights that shine only through a portal.
std::vector<std::uint32_t> portal_lights(const Scene& scene);

/// What the samples of one answer found.
struct FoundLight {
  std::uint64_t by_chance = 0;  ///< lamps, by way of smooth surfaces (WorkCounts)
  std::uint64_t cut_short = 0;  ///< (WorkCounts)
  std::uint64_t reflected = 0;  ///< samples with light that surfaces reflect
};

/// Immutable; may be called from any thread.
class MissedLightRule {
 public:
  /// `scene` must outlive this object.  `bounces`: the most reflections; unset: all.
  MissedLightRule(const Scene& scene, std::optional<std::uint32_t> bounces);

  /// `rule`: the interval rule of the answer's samples.
  MissedLight at(const SurfaceHit& receiver, const FoundLight& found,
                 const IntervalRule& rule) const;
  /// Whether the receiver is outdoors of a portal: on the side that its light comes from, and in
  /// sight of the sky.
  bool is_outdoors(const SurfaceHit& receiver) const;

 private:
  const Scene& scene_;
  std::vector<std::uint32_t> portals_;
  const SmoothSurfaces* surfaces_ = nullptr;  ///< null: nothing is reflected
  bool once_ = false;                         ///< at most one reflection
  bool has_deltas_ = false;
  /// The largest luminance of lights with a size [cd/m2]; infinite if it is not known.
  double most_cd_m2_ = 0;
};

}  // namespace lucerna
