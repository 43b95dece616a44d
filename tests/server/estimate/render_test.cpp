#include "server/estimate/render.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

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
  const int width = scene->camera().width();
  std::uint64_t samples = 0;
  for (const PixelRect& r : testing::kTiles) {
    TileSettings part = settings;
    part.rect = r;
    const TileResult tile = render_tile(*scene, part, {});
    samples += tile.work.samples;
    std::size_t i = 0;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x)
        for (int c = 0; c < 3; ++c, ++i)
          ASSERT_TRUE(same(tile.channels[i],
                           all.channels[static_cast<std::size_t>(3 * (y * width + x) + c)]))
              << x << " " << y;
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

TEST(RenderTile, GivesTheSameBitsForAnySplitOfSamples) {
  const auto scene = busy_scene();
  for (const bool one_sequence : {false, true}) {
    TileSettings settings = whole(*scene);
    settings.one_sequence = one_sequence;
    const TileResult all = render_tile(*scene, settings, {});
    BlockMerger merger(8, all.channels.size());
    for (const auto& [first, count] : {std::pair{8, 4}, {12, 2}, {14, 1}, {15, 1}}) {
      settings.first_block = static_cast<std::uint64_t>(first);
      settings.block_count = static_cast<std::uint64_t>(count);
      ASSERT_TRUE(merger.add(settings.first_block, settings.block_count,
                             render_tile(*scene, settings, {}).channels));
    }
    const auto merged = merger.total();
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
  BlockMerger<LuminanceMoments> merger(8, all.moments.size());
  for (const auto& [first, count] : {std::pair{8, 4}, {12, 2}, {14, 1}, {15, 1}}) {
    settings.first_block = static_cast<std::uint64_t>(first);
    settings.block_count = static_cast<std::uint64_t>(count);
    ASSERT_TRUE(merger.add(settings.first_block, settings.block_count,
                           render_tile(*scene, settings, {}).moments));
  }
  EXPECT_EQ(bytes_of(merger.total()), bytes_of(all.moments));
  // The luminance of the picture.
  for (std::size_t i = 0; i < all.moments.size(); ++i) {
    const auto* c = &all.channels[3 * i];
    const double sum = luminance(Rgb{c[0].sum, c[1].sum, c[2].sum});
    EXPECT_NEAR(all.moments[i].blocks.sum, sum, 1e-12 * sum);
  }
}

TEST(RenderTile, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto scene = busy_scene();
  const auto with_threads = [&](int threads) {
    tbb::task_arena arena(threads);
    return arena.execute([&] { return render_tile(*scene, whole(*scene), {}); });
  };
  const TileResult one = with_threads(1), two = with_threads(2);
  for (std::size_t i = 0; i < one.channels.size(); ++i)
    ASSERT_TRUE(same(one.channels[i], two.channels[i]));
  EXPECT_EQ(one.work.shadow_rays, two.work.shadow_rays);
  EXPECT_EQ(one.work.indirect_rays, two.work.indirect_rays);
}

TEST(RenderTile, GivesOtherBitsForAnotherSeed) {
  const auto scene = busy_scene();
  TileSettings settings = whole(*scene);
  const TileResult a = render_tile(*scene, settings, {});
  settings.seed = 6;
  const TileResult b = render_tile(*scene, settings, {});
  EXPECT_FALSE(same(a.channels[300], b.channels[300]));
}

TEST(RenderTile, StopsOnRequest) {
  const auto scene = busy_scene();
  TileSettings settings = whole(*scene);
  settings.samples_per_block = 1u << 30;  // hours
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(render_tile(*scene, settings, stop.get_token()).stopped);
}

/// Mean of all channels of a picture, with the standard error of it from blocks.
struct Mean {
  double value, standard_error;
};
Mean mean_of(const TileResult& tile, double blocks) {
  double sum = 0, variance = 0;
  for (const BlockStatistics& s : tile.channels) {
    sum += s.sum / blocks;
    variance += s.deviation / (blocks * (blocks - 1));
  }
  const auto n = static_cast<double>(tile.channels.size());
  // The three channels of a grey pixel are one number three times.
  return {sum / n, std::sqrt(3 * variance) / n};
}

// Within a closed white box that emits L and reflects rho, radiance is L / (1 - rho) everywhere.
// It is L (1 + rho + ... + rho^(b+1)) where light is reflected up to b + 1 times.
class Furnace : public ::testing::TestWithParam<double> {
 protected:
  std::shared_ptr<const Scene> scene() const {
    SceneDescription d = testing::description(GetParam());
    d.shapes = {testing::emissive({testing::room({1, 2, 3})}, 2)};
    d.camera.world_from_camera = *Transform::look_at({1.2, 1.5, 2.6}, {2, 3, 3.3}, {0, 0, 1});
    return build(std::move(d));
  }
  TileSettings settings(std::optional<std::uint32_t> bounces) const {
    return {.rect = {0, 0, 16, 12},
            .seed = 3,
            .samples_per_block = 8,
            .block_count = 16,
            .bounces = bounces};
  }
};

// Five standard errors, exceeded by chance once in 1.7 million.
TEST_P(Furnace, HoldsTheGeometricSeriesForAnyNumberOfBounces) {
  const auto room = scene();
  const double rho = GetParam();
  for (const std::uint32_t bounces : {0u, 1u, 4u}) {
    const Mean m = mean_of(render_tile(*room, settings(bounces), {}), 16);
    double expected = 2, term = 2;
    for (std::uint32_t i = 0; i <= bounces; ++i) expected += term *= rho;
    EXPECT_NEAR(m.value, expected, 5 * m.standard_error + 1e-5) << bounces;
    EXPECT_LT(m.standard_error, 0.01 * expected);
  }
}

TEST_P(Furnace, HoldsWithRussianRoulette) {
  const Mean m = mean_of(render_tile(*scene(), settings({}), {}), 16);
  const double expected = 2 / (1 - GetParam());
  EXPECT_NEAR(m.value, expected, 5 * m.standard_error);
  EXPECT_LT(m.standard_error, 0.02 * expected);
}

INSTANTIATE_TEST_SUITE_P(Reflectances, Furnace, ::testing::Values(0.2, 0.5, 0.9));

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

struct PictureMean {
  double value = 0, variance = 0;
};

// The mean of the green channel over the whole picture.
PictureMean picture_mean(const SceneDescription& description) {
  const auto scene = build(description);
  TileSettings settings = whole(*scene);
  settings.samples_per_block = 64;
  const TileResult tile = render_tile(*scene, settings, {});
  const auto n = static_cast<double>(settings.block_count);
  const auto pixels = static_cast<double>(tile.channels.size()) / 3;
  PictureMean mean;
  for (std::size_t i = 1; i < tile.channels.size(); i += 3) {
    mean.value += tile.channels[i].sum / n / pixels;
    mean.variance += tile.channels[i].deviation / (n * (n - 1)) / (pixels * pixels);
  }
  return mean;
}

// A lamp, the sky and `points` point lights; `kept`: -1 for all of them, or the index of the only
// one.
SceneDescription lit(int points, int kept) {
  SceneDescription d = testing::description(0.6);
  d.camera.world_from_camera = *Transform::look_at({0, -6, 3}, {0, 0, 0.5}, {0, 0, 1});
  ShapeDescription lamp{DiskParams{.radius_m = 0.5,
                                   .reverse_orientation = true,
                                   .world_from_object = Transform::translate({1, 1, 3})}};
  if (kept < 0 || kept == points) lamp = testing::emissive(lamp, 30);
  d.shapes = {testing::floor(4),
              {SphereParams{.world_from_object = Transform::translate({0, 0, 1})}},
              lamp};
  for (int i = 0; i < points; ++i)
    if (kept < 0 || kept == i)
      d.lights.push_back(testing::point_light({-2.0 + 0.5 * i, -1, 3}, 2.0 + i));
  if (kept < 0 || kept == points + 1)
    d.lights.push_back({UniformInfiniteLightParams{Rgb(0.3)}, {}});
  return d;
}

class SeveralLights : public ::testing::TestWithParam<int> {};

// Few lights are all candidates of every shadow ray; many are drawn by power.  The seed is fixed.
// The limit is six standard errors, exceeded by chance once in 5e8.
TEST_P(SeveralLights, GiveTheSumOfEachAlone) {
  const int points = GetParam();
  const PictureMean together = picture_mean(lit(points, -1));
  PictureMean sum;
  for (int i = 0; i < points + 2; ++i) {
    const PictureMean one = picture_mean(lit(points, i));
    sum.value += one.value;
    sum.variance += one.variance;
  }
  const double error = std::sqrt(together.variance + sum.variance);
  EXPECT_NEAR(together.value, sum.value, 6 * error);
  // Accurate enough to notice one light of the smallest share that is missing or counted twice.
  EXPECT_LT(6 * error, 0.01 * sum.value);
}

INSTANTIATE_TEST_SUITE_P(FewAndMany, SeveralLights, ::testing::Values(2, 9));

TEST(RenderTile, ReflectsAPointLightByTheCosineLaw) {
  // Straight down on the middle of a floor, with the light 2 m above it: L = rho I / (pi 4).
  SceneDescription d = testing::description(0.8);
  d.shapes = {testing::floor(1)};
  d.lights = {testing::point_light({0, 0, 2}, 10)};
  d.camera.world_from_camera = *Transform::look_at({0, 0, 1}, {0, 0, 0}, {0, 1, 0});
  d.camera.screen_min = {-1e-3, -1e-3};
  d.camera.screen_max = {1e-3, 1e-3};
  const auto scene = build(std::move(d));
  TileSettings settings = whole(*scene);
  settings.bounces = 0;
  const TileResult tile = render_tile(*scene, settings, {});
  for (const BlockStatistics& s : tile.channels)
    EXPECT_NEAR(s.sum / 8, 0.8 * 10 / (4 * std::numbers::pi), 1e-5);
}

}  // namespace
}  // namespace lucerna
