#include "server/estimate/render.h"

#include <gtest/gtest.h>

#include "tests/server/estimate/tiles.h"

namespace lucerna {
namespace {

using testing::build;
using testing::same;

// A scene with several lights of several kinds, bounces and shadows.
std::shared_ptr<const Scene> busy_scene() {
  SceneDescription d = testing::ball_under_a_lamp(4);
  d.lights = {testing::point_light({-2, -1, 3}, 10),
              {UniformInfiniteLightParams{Rgb(0.2, 0.3, 0.5)}, {}}};
  d.camera.world_from_camera = *Transform::look_at({0, -6, 3}, {0, 0, 0.5}, {0, 0, 1});
  return build(std::move(d));
}

TileSettings whole(const Scene& scene) {
  return {.rect = {0, 0, scene.camera().width(), scene.camera().height()},
          .seed = 5,
          .samples_per_block = 4,
          .first_block = 8,
          .block_count = 8};
}

TEST(RenderTile, GivesTheSameBitsForAnyTiling) {
  const auto scene = busy_scene();
  const TileSettings settings = whole(*scene);
  const TileResult all = render_tile(*scene, settings, {});
  std::uint64_t samples = 0;
  for (const PixelRect& r : testing::kTiles) {
    TileSettings part = settings;
    part.rect = r;
    const TileResult tile = render_tile(*scene, part, {});
    samples += tile.work.samples;
    testing::expect_part(tile, r, all, scene->camera().width());
  }
  EXPECT_EQ(samples, all.work.samples);
  EXPECT_EQ(samples, 16u * 12 * 32);
}

// A smooth integrand: Owen scrambling makes the variance of 64 samples of one sequence far smaller
// than that of eight independent blocks.  [LEcuyer23]
TEST(RenderTile, OneSequenceHasLessNoiseThanIndependentBlocks) {
  SceneDescription d = testing::ball_under_a_lamp(4);
  d.camera.world_from_camera = *Transform::look_at({0, -6, 3}, {0, 0, 0.5}, {0, 0, 1});
  const auto scene = build(std::move(d));
  TileSettings settings = whole(*scene);
  settings.bounces = 0;
  settings.samples_per_block = 8;
  settings.first_block = 0;
  const auto squared_error = [&](bool one_sequence) {
    settings.one_sequence = one_sequence;
    std::vector<std::vector<BlockStatistics>> pictures;
    for (settings.seed = 0; settings.seed < 32; ++settings.seed)
      pictures.push_back(render_tile(*scene, settings, {}).channels);
    double sum = 0;
    for (std::size_t i = 0; i < pictures[0].size(); ++i) {
      double mean = 0;
      for (const auto& p : pictures) mean += p[i].sum / 32;
      for (const auto& p : pictures) sum += (p[i].sum - mean) * (p[i].sum - mean);
    }
    return sum;
  };
  const double blocks = squared_error(false), one = squared_error(true);
  EXPECT_GT(one, 0);
  // Measured: a quarter to a half.  The sums have thousands of terms, so luck moves them by 5%.
  EXPECT_LT(one, 0.7 * blocks);
}

/// The variances of all pixels of a picture, each of eight blocks in one sequence: as the scatter
/// of the blocks reports it, and as pictures of 32 seeds have it.
struct Variances {
  double reported = 0, actual = 0;
};
Variances variances_of_one_sequence(const Scene& scene, std::uint32_t bounces) {
  constexpr std::uint32_t kSeeds = 32, kBlocks = 8;
  TileSettings settings = whole(scene);
  settings.bounces = bounces;
  settings.samples_per_block = settings.block_count = kBlocks;
  settings.first_block = 0;
  settings.one_sequence = true;
  std::vector<std::vector<BlockStatistics>> pictures;
  for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed)
    pictures.push_back(render_tile(scene, settings, {}).channels);
  Variances v;
  for (std::size_t i = 0; i < pictures[0].size(); ++i) {
    double mean = 0;
    for (const auto& p : pictures) mean += p[i].sum / kSeeds;
    for (const auto& p : pictures) {
      v.reported += p[i].deviation * kBlocks / (kBlocks - 1);
      v.actual += (p[i].sum - mean) * (p[i].sum - mean) * kSeeds / (kSeeds - 1);
    }
  }
  return v;
}

TEST(RenderTile, OneSequenceReportsAtLeastItsError) {
  SceneDescription d = testing::ball_under_a_lamp(4);
  d.camera.world_from_camera = *Transform::look_at({0, -6, 3}, {0, 0, 0.5}, {0, 0, 1});
  for (const auto& scene : {build(std::move(d)), busy_scene()}) {
    for (const std::uint32_t bounces : {0U, 3U}) {
      const Variances v = variances_of_one_sequence(*scene, bounces);
      EXPECT_GT(v.reported, v.actual) << bounces;
      EXPECT_GT(v.actual, 0) << bounces;
    }
  }
}

/// Merges blocks 8 to 15 from four answers of `render`.
template <typename Block, typename BlocksOf>
std::vector<Block> merged_of_four(std::size_t size, TileSettings settings, BlocksOf&& render) {
  BlockMerger<Block> merger(8, size);
  for (const auto& [first, count] : {std::pair{8, 4}, {12, 2}, {14, 1}, {15, 1}}) {
    settings.first_block = static_cast<std::uint64_t>(first);
    settings.block_count = static_cast<std::uint64_t>(count);
    EXPECT_TRUE(merger.add(settings.first_block, settings.block_count, render(settings)));
  }
  return merger.total();
}

TEST(RenderTile, GivesTheSameBitsForAnySplitOfSamples) {
  const auto scene = busy_scene();
  for (const bool one_sequence : {false, true}) {
    TileSettings settings = whole(*scene);
    settings.one_sequence = one_sequence;
    const TileResult all = render_tile(*scene, settings, {});
    const auto merged = merged_of_four<BlockStatistics>(
        all.channels.size(), settings,
        [&](const TileSettings& s) { return render_tile(*scene, s, {}).channels; });
    for (std::size_t i = 0; i < merged.size(); ++i) ASSERT_TRUE(same(merged[i], all.channels[i]));
  }
}

TEST(RenderTile, GivesTheSameMomentsForAnySplitAndTheSamePictureWithoutThem) {
  const auto scene = busy_scene();
  TileSettings settings = whole(*scene);
  const TileResult plain = render_tile(*scene, settings, {});
  EXPECT_TRUE(plain.moments.empty());
  settings.intervals = true;
  const TileResult all = render_tile(*scene, settings, {});
  for (std::size_t i = 0; i < all.channels.size(); ++i)
    ASSERT_TRUE(same(all.channels[i], plain.channels[i]));
  ASSERT_EQ(all.moments.size(), 16U * 12);
  const auto merged = merged_of_four<LuminanceMoments>(
      all.moments.size(), settings,
      [&](const TileSettings& s) { return render_tile(*scene, s, {}).moments; });
  EXPECT_EQ(bytes_of(merged), bytes_of(all.moments));
  // The luminance of the picture.
  for (std::size_t i = 0; i < all.moments.size(); ++i) {
    const auto* c = &all.channels[3 * i];
    const double sum = luminance(Rgb{c[0].sum, c[1].sum, c[2].sum});
    EXPECT_NEAR(all.moments[i].blocks.sum, sum, 1e-12 * sum);
  }
}

TEST(RenderTile, StopsOnRequest) {
  const auto scene = busy_scene();
  TileSettings settings = whole(*scene);
  settings.samples_per_block = 1u << 30;  // hours
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(render_tile(*scene, settings, stop.get_token()).stopped);
}

TEST(RenderTile, ShowsEmissionTimesTheFilmsScale) {
  SceneDescription d = testing::description();
  d.lights = {{UniformInfiniteLightParams{{0.25, 0.5, 1}}, {}}};
  d.film.scale = 4;
  const auto scene = build(std::move(d));
  const TileResult tile = render_tile(*scene, whole(*scene), {});
  EXPECT_EQ(tile.channels[0].sum / 8, 1);
  EXPECT_EQ(tile.channels[1].sum / 8, 2);
  EXPECT_EQ(tile.channels[2].sum / 8, 4);
  EXPECT_EQ(tile.channels[0].deviation, 0);
}

TEST(RenderTile, EndsBetweenWhiteWallsForAnyNumberOfBounces) {
  // Nothing is absorbed: light is reflected 2^32 times.
  SceneDescription d = testing::description(1);
  d.shapes = {testing::shape(testing::room())};
  d.lights = {testing::point_light({0, 0, 0.5}, 1)};
  const auto scene = build(std::move(d));
  TileSettings settings{.rect = {0, 0, 8, 8}, .seed = 3, .bounces = 0xFFFFFFFF};
  const TileResult r = render_tile(*scene, settings, {});
  // Paths continue for 1 / (1 - 0.95) = 20 more reflections.
  EXPECT_GT(r.work.indirect_rays, 64 * 256U);
  EXPECT_LT(r.work.indirect_rays, 64 * 300U);
}

}  // namespace
}  // namespace lucerna
