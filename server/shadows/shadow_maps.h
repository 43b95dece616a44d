// The shadow maps of a scene: one for each light that has one, made when it is first asked for.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "server/scene/scene.h"
#include "server/shadows/shadow_map.h"

namespace lucerna {

/// Of lights at a point and distant lights that rest, in scenes where no surface moves.  All
/// members may be called from any thread.
class ShadowMaps : public AttachedPart {
 public:
  /// Texels of all maps together, at most: 128 MiB, which take 14 to 17 s of one core on the scenes
  /// of scenes/.
  static constexpr std::uint64_t kMostTexels = std::uint64_t{1} << 25;
  /// Texels along a face's side at most: a texel is then 0.09 degrees wide, 1.5 cm in 10 m, about
  /// what a shadow's edge is seen to be off by in a picture.
  static constexpr std::uint32_t kLargestSide = 1024;
  /// At least, 6 degrees a texel: with so many lights that there is no room for that none has a
  /// map.
  static constexpr std::uint32_t kLeastSide = 16;

  /// `scene` outlives it.  Makes no map yet.
  explicit ShadowMaps(const Scene& scene);

  /// The map of the light of this index, made by the threads of the caller's arena where it is not
  /// there yet.  Null where that light keeps rays.
  const ShadowMap* map(std::uint32_t light) const;

  /// Texels along the side of each face: as many as kMostTexels allow when all lights have maps,
  /// so that which maps were made before says nothing about an answer.
  std::uint32_t side() const { return side_; }

  /// Processor time that it takes to make those that are not there yet, an upper estimate [s].
  double seconds_left() const;

  std::uint64_t bytes() const override;
  /// Empty while no map is made.
  std::optional<ScenePart> report() const override;

 private:
  const Scene& scene_;
  std::uint32_t side_ = 0;
  std::vector<std::int32_t> number_;  // of each light's map; -1: it keeps rays
  std::vector<ShadowMapView> views_;
  std::deque<LazyPart<ShadowMap>> maps_;  // a deque, as locks do not move
};

inline const ShadowMaps& shadow_maps(const Scene& scene) { return scene.attached<ShadowMaps>(); }

}  // namespace lucerna
