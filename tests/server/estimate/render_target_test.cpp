// Tiles with a target error: each pixel gets its own sample count.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <stop_token>

#include "server/estimate/render.h"
#include "tests/server/estimate/coverage_scenes.h"
#include "tests/server/estimate/tiles.h"

namespace lucerna {
namespace {

using testing::build;
using testing::same;

/// Bright and dark, edges, shadows and reflections.
std::shared_ptr<const Scene> scene() {
  SceneDescription d = testing::ball_under_a_lamp(3);
  d.film.scale = 0.25;
  d.camera.world_from_camera = *Transform::look_at({0, -6, 3}, {0, 0, 1}, {0, 0, 1});
  return build(std::move(d));
}

TileSettings within(const Scene& scene, double relative, std::uint64_t max_samples = 4096) {
  return {.rect = {0, 0, scene.camera().width(), scene.camera().height()},
          .seed = 5,
          .block_count = 32,
          .bounces = 2,
          .target = TargetError{.relative = relative, .max_samples = max_samples}};
}

double luminance_of(const TileResult& r, std::size_t i) {
  return luminance(
             Rgb{r.channels[3 * i].sum, r.channels[3 * i + 1].sum, r.channels[3 * i + 2].sum}) /
         32;
}

TEST(RenderTarget, GivesEachPixelTheBitsOfAQueryForItsCount) {
  const auto s = scene();
  const TileResult r = render_tile(*s, within(*s, 0.1), {});
  ASSERT_EQ(r.samples.size(), 16U * 12);
  ASSERT_EQ(r.intervals.size(), 16U * 12);
  for (std::size_t i = 0; i < r.samples.size(); ++i) {
    ASSERT_TRUE(std::has_single_bit(r.samples[i]));
    ASSERT_GE(r.samples[i], 64U);
    TileSettings one = within(*s, 0.1);
    one.target.reset();
    const int x = static_cast<int>(i % 16), y = static_cast<int>(i / 16);
    one.rect = {x, y, x + 1, y + 1};
    one.samples_per_block = r.samples[i] / 32;
    const TileResult again = render_tile(*s, one, {});
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_TRUE(same(again.channels[c], r.channels[3 * i + c])) << x << " " << y;
    EXPECT_TRUE(again.samples.empty());
    EXPECT_LE(r.intervals[i].lower, luminance_of(r, i) * (1 + 1e-15));
    EXPECT_GE(r.intervals[i].upper, luminance_of(r, i) * (1 - 1e-15));
  }
  // The sample counts of pixels differ.
  const auto [least, most] = std::minmax_element(r.samples.begin(), r.samples.end());
  EXPECT_EQ(*least, 64U);
  EXPECT_GE(*most, 1024U);
}

TEST(RenderTarget, GivesTheSameBitsForAnyTilesAndThreads) {
  const auto s = scene();
  const TileSettings settings = within(*s, 0.2);
  tbb::task_arena alone(1);
  const TileResult all = alone.execute([&] { return render_tile(*s, settings, {}); });
  WorkCounts work;
  for (const PixelRect& r : testing::kTiles) {
    TileSettings part = settings;
    part.rect = r;
    const TileResult tile = render_tile(*s, part, {});
    work += tile.work;
    testing::expect_part(tile, r, all, 16);
    std::size_t i = 0;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x, ++i) {
        const auto k = static_cast<std::size_t>(16 * y + x);
        ASSERT_EQ(tile.samples[i], all.samples[k]);
        ASSERT_EQ(tile.intervals[i].lower, all.intervals[k].lower);
        ASSERT_EQ(tile.intervals[i].upper, all.intervals[k].upper);
      }
  }
  EXPECT_EQ(work.samples, all.work.samples);
  EXPECT_EQ(work.shadow_rays, all.work.shadow_rays);
}

TEST(RenderTarget, SmallerErrorAndHigherConfidenceTakeMoreSamples) {
  const auto s = scene();
  const auto samples = [&](const TileSettings& settings) {
    return render_tile(*s, settings, {}).work.samples;
  };
  const std::uint64_t coarse = samples(within(*s, 0.1, 1 << 16));
  TileSettings sure = within(*s, 0.1, 1 << 16);
  sure.target->confidence = 0.999;
  EXPECT_GT(samples(sure), coarse);
  EXPECT_GT(samples(within(*s, 0.05, 1 << 16)), coarse);
}

TEST(RenderTarget, StopsAtTheLargestSampleCount) {
  // No light comes through the lid, for any number of samples.
  SceneDescription d = testing::below_a_lid(0.5);
  d.film.scale = 4;
  d.camera.world_from_camera = *Transform::look_at({0, 0, 1}, {}, {0, 1, 0});
  const auto s = build(std::move(d));
  TileSettings settings = within(*s, 0.1, 1500);
  settings.bounces = 0;
  TileResult r = render_tile(*s, settings, {});
  for (std::size_t i = 0; i < r.samples.size(); ++i) {
    EXPECT_EQ(r.samples[i], 1024U);  // the power of two below
    EXPECT_EQ(r.channels[3 * i].sum, 0);
    EXPECT_EQ(r.intervals[i].lower, 0);
    // At most 3 in 1024 samples saw light.  None saw more than the unoccluded lamp gives the floor:
    // less than pi times its 7 cd/m2, times 0.5 / pi.
    EXPECT_GT(r.intervals[i].upper, 0);
    EXPECT_LT(r.intervals[i].upper, 4 * 3.0 / 1024 * 7 * 4);
  }
  // With an absolute floor above that bound.
  settings.target->absolute_floor = 4;
  r = render_tile(*s, settings, {});
  for (const std::uint32_t n : r.samples) EXPECT_EQ(n, 64U);
}

TEST(RenderTarget, IsExactWithoutSampling) {
  // A lamp fills the picture.  The other camera sees nothing.
  SceneDescription d = testing::description(0);
  d.shapes = {testing::emissive(testing::patch({-9, -9, 3}, {-9, 9, 3}, {9, -9, 3}, {9, 9, 3}), 5)};
  d.camera.world_from_camera = *Transform::look_at({0, 0, 1}, {0, 0, 3}, {0, 1, 0});
  const auto lit = build(d);
  d.camera.world_from_camera = *Transform::look_at({0, 0, 1}, {0, 0, 0}, {0, 1, 0});
  const auto dark = build(d);
  for (const auto& [s, value] : {std::pair{lit, 5.0}, {dark, 0.0}}) {
    const TileResult r = render_tile(*s, within(*s, 0.01), {});
    for (std::size_t i = 0; i < r.samples.size(); ++i) {
      EXPECT_EQ(r.samples[i], 64U);
      EXPECT_NEAR(r.intervals[i].lower, value, 1e-12);
      EXPECT_NEAR(r.intervals[i].upper, value, 1e-12);
    }
  }
}

TEST(RenderTarget, StopsOnRequest) {
  const auto s = scene();
  const TileSettings settings = within(*s, 1e-9, std::uint64_t{1} << 31);  // days
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(render_tile(*s, settings, stop.get_token()).stopped);
}

}  // namespace
}  // namespace lucerna
