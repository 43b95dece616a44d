// Helpers for tests of tiles: a scene, a division into tiles, and a comparison of pixels.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

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

/// Expects the channels of pixels of `tile`, which has the rectangle `r` of the picture `all`.
inline void expect_part(const TileResult& tile, const PixelRect& r, const TileResult& all,
                        int width) {
  std::size_t i = 0;
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x)
      for (int c = 0; c < 3; ++c, ++i)
        ASSERT_TRUE(
            same(tile.channels[i], all.channels[static_cast<std::size_t>(3 * (y * width + x) + c)]))
            << x << " " << y;
}

inline constexpr int kMoments = 64;

/// Expects a picture of the time from 0 s to 1 s to be the mean of pictures of kMoments moments,
/// with `blocks` blocks each.  Returns that mean.  `slack`: an error of the midpoint rule.
inline std::vector<double> expect_mean_of_moments(const TileResult& blurred, const Scene& scene,
                                                  const TileSettings& s, std::uint64_t blocks,
                                                  double slack) {
  const auto n = static_cast<double>(blocks), all = static_cast<double>(s.block_count);
  std::vector<double> mean(blurred.channels.size()), variance(mean.size());
  for (int k = 0; k < kMoments; ++k) {
    TileSettings moment = s;
    moment.seed = 100 + static_cast<std::uint64_t>(k);
    moment.block_count = blocks;
    moment.time_s = (k + 0.5) / kMoments;
    const TileResult still = render_tile(scene, moment, {});
    for (std::size_t c = 0; c < mean.size(); ++c) {
      mean[c] += still.channels[c].sum / n / kMoments;
      variance[c] += still.channels[c].deviation / (n * (n - 1)) / (kMoments * kMoments);
    }
  }
  for (std::size_t c = 0; c < mean.size(); ++c) {
    const double v = variance[c] + blurred.channels[c].deviation / (all * (all - 1));
    // Seven standard errors for 120 numbers, exceeded by chance less than once in 1e9.  The smooth
    // part of the midpoint rule's error is below 1e-3.
    EXPECT_NEAR(blurred.channels[c].sum / all, mean[c], 7 * std::sqrt(v) + slack + 1e-3 * mean[c]);
    EXPECT_GT(mean[c], 0);
  }
  return mean;
}

}  // namespace lucerna::testing
