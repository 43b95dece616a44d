// Helpers for tests of tiles: a scene, a division into tiles, and a comparison of pixels.
#pragma once

#include <array>

#include "proto/common/tile_statistics.h"
#include "server/estimate/render.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {

/// A ball on a floor under a disk light.  The floor extends `floor_m` to each side.
inline SceneDescription ball_under_a_lamp(double floor_m) {
  SceneDescription d = description(0.7);
  d.shapes = {floor(floor_m),
              {SphereParams{.world_from_object = Transform::translate({0, 0, 1})}},
              emissive({DiskParams{.radius_m = 0.5,
                                   .reverse_orientation = true,
                                   .world_from_object = Transform::translate({1, 1, 3})}},
                       20)};
  return d;
}

/// The film of `description()`, 16 x 12 pixels, in tiles of different sizes.
inline constexpr std::array<PixelRect, 4> kTiles{
    PixelRect{0, 0, 7, 5}, {7, 0, 16, 5}, {0, 5, 16, 6}, {0, 6, 16, 12}};

inline bool same(const BlockStatistics& a, const BlockStatistics& b) {
  return a.sum == b.sum && a.deviation == b.deviation;
}

}  // namespace lucerna::testing
