// The shadow maps of a scene.  The map of a light is made at its first use.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "server/scene/scene.h"
#include "server/visibility/shadow_map.h"

namespace lucerna {

/// Lights at a point and distant lights have maps, if neither they nor any surfaces move. All
/// members may be called from any thread.
class ShadowMaps : public AttachedPart {
 public:
  /// Limit for the texels of all maps: 128 MiB.  Making them takes 14 to 17 s of one core on the
  /// scenes of scenes/.
  static constexpr std::uint64_t kMostTexels = std::uint64_t{1} << 25;
  /// Limit for the texels along a side of a face.  A texel is then 0.09 degrees wide, or 1.5
  /// cm at 10 m.  Errors of shadow edges become visible at about that size.
  static constexpr std::uint32_t kLargestSide = 1024;
  /// Least number of texels along a side, 6 degrees each.  If there are too many lights for this,
  /// no light has a map.
  static constexpr std::uint32_t kLeastSide = 16;

  /// `scene` must outlive it.  Makes no map yet.
  explicit ShadowMaps(const Scene& scene);

  /// The map of the light with this index.  Made at the first call, on the threads of the
  /// caller's arena.  Null for lights without maps.
  const ShadowMap* map(std::uint32_t light) const;

  /// Texels along the side of each face: as many as kMostTexels allows if all lights have
  /// maps.  So answers do not depend on which maps were made before.
  std::uint32_t side() const { return side_; }

  /// Upper estimate of the processor time to make the maps that are missing [s].
  double seconds_left() const;

  std::uint64_t bytes() const override;
  /// Nothing until a map is made.
  std::optional<ScenePart> report() const override;

 private:
  const Scene& scene_;
  std::uint32_t side_ = 0;
  std::vector<std::int32_t> number_;  // index of each light's map; -1: no map
  std::vector<ShadowMapView> views_;
  std::deque<LazyPart<ShadowMap>> maps_;  // a deque, because locks cannot be moved
};

inline const ShadowMaps& shadow_maps(const Scene& scene) { return scene.attached<ShadowMaps>(); }

}  // namespace lucerna
