// The coverage of pixel intervals over repeats.
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <numbers>
#include <vector>

#include "server/estimate/render.h"
#include "tests/server/estimate/coverage.h"
#include "tests/server/estimate/coverage_scenes.h"

namespace lucerna::testing {
namespace {

using std::numbers::pi;

/// A query for one pixel.
struct PixelQuestion {
  std::string name;
  std::shared_ptr<const Scene> scene;
  double truth;  // [cd/m2]
  std::optional<std::uint32_t> bounces = 0;
};

/// A camera of 1 x 1 pixels that sees `metres` of a surface 1 m away.
void look(SceneDescription& d, const Vec3& from, const Vec3& at, double metres) {
  d.film = {.width = 1, .height = 1};
  d.camera.world_from_camera = *Transform::look_at(from, at, {0.3, 1, 0});
  d.camera.screen_min = {-metres / 2, -metres / 2};
  d.camera.screen_max = {metres / 2, metres / 2};
}

// So small a part of the floor that its light is uniform.
constexpr double kSpot = 1e-3;

PixelQuestion lamp_pixel() {
  SceneDescription d = below_a_lamp(0.5);
  look(d, {0, 0, 1}, {}, kSpot);
  return {"lamp", build(std::move(d)), 0.5 * lux_below_a_lamp() / pi};
}

/// The floor ends within the pixel and fills `share` of it.  Its light needs no sample.  The pixel
/// is large: points cover it so evenly that the rounding of floats would be noticeable.
PixelQuestion edge_pixel(double share = 0.3) {
  SceneDescription d = description(0.5);
  const double end = share - 0.5;
  d.shapes = {patch({-9, -9, 0}, {end, -9, 0}, {-9, 9, 0}, {end, 9, 0})};
  d.lights = {{DistantLightParams{{0, 0, 1}, Rgb(10)}, {}}};
  look(d, {0, 0, 1}, {}, 1);
  d.camera.world_from_camera = *Transform::look_at({0, 0, 1}, {}, {0, 1, 0});
  return {"edge " + std::to_string(share), build(std::move(d)), share * 0.5 * 10 / pi};
}

PixelQuestion furnace_pixel() {
  SceneDescription d = in_a_furnace();
  look(d, {0.1, 0.2, -0.3}, {1, 0.3, 0.4}, 1);
  return {"furnace", build(std::move(d)), kFurnaceRadiance, std::nullopt};
}

PixelQuestion pinhole_pixel() {
  SceneDescription d = below_a_pinhole(0.5);
  look(d, {0, 0, 1}, {}, kSpot);
  return {"pinhole", build(std::move(d)), 0.5 * lux_below_a_pinhole() / pi};
}

/// One repeat.
Answer answer(const PixelQuestion& q, TileSettings settings, std::uint64_t seed) {
  settings.rect = {0, 0, 1, 1};
  settings.bounces = q.bounces;
  settings.seed = seed;
  settings.intervals = true;
  const TileResult r = render_tile(*q.scene, settings, {});
  const auto n = static_cast<double>(settings.block_count);
  const auto value = [&](int c) { return r.channels[c].sum / n; };
  const double mean = luminance(Rgb{value(0), value(1), value(2)});
  if (settings.target) return {mean, r.intervals[0]};
  const FloatInterval i =
      pixel_intervals(r.moments, settings.block_count, settings.samples_per_block)[0];
  return {mean, {i.lower, i.upper}};
}

Coverage coverage_of(const PixelQuestion& q, const TileSettings& settings) {
  return repeated(q.truth, [&](std::uint64_t i) { return answer(q, settings, i); });
}

TileSettings within(double relative) {
  return {.block_count = 32, .target = TargetError{.relative = relative}};
}

TEST(RenderCoverage, OfSmoothLightByACount) {
  for (const std::uint32_t each : {8U, 32U, 64U})
    expect_covered(coverage_of(lamp_pixel(), {.samples_per_block = each, .block_count = 8}),
                   "lamp, " + std::to_string(each) + " samples a block");
  // Skewed light is held in 96% to 98.5%: the upper ends reach farther for rare bright samples.
  for (const std::uint32_t each : {8U, 32U, 64U})
    expect_covered_at_least(
        coverage_of(furnace_pixel(), {.samples_per_block = each, .block_count = 8}),
        "furnace, " + std::to_string(each) + " samples a block");
}

// Blocks have nearly the same number of samples on each side of an edge.  Often all are equal, and
// their standard error is 0.  The rule of three holds more often than stated: the number of samples
// on a side takes few values.  IntervalExtremes.Edges has sample counts.
TEST(RenderCoverage, OfEdgesByATarget) {
  for (const double share : {0.26, 0.51})
    for (const double relative : {0.1, 0.02})
      expect_covered_at_least(
          coverage_of(edge_pixel(share), within(relative)),
          "edge " + std::to_string(share) + " within " + std::to_string(relative));
}

TEST(RenderCoverage, OfSmoothLightByATarget) {
  for (const PixelQuestion& q : {lamp_pixel(), furnace_pixel()})
    for (const double relative : {0.1, has_time_for_large_counts() ? 0.02 : 0.04})
      expect_covered(coverage_of(q, within(relative)),
                     q.name + " within " + std::to_string(relative));
  // With 64 samples, so few find the edge's light that intervals may hold it too often.
  for (const PixelQuestion& q : {lamp_pixel(), edge_pixel()})
    expect_covered_at_least(coverage_of(q, within(1)), q.name + " within 1");
}

TEST(RenderCoverage, OfLightThroughAPinhole) {
  const PixelQuestion q = pinhole_pixel();
  if (has_time_for_large_counts()) expect_covered_at_least(coverage_of(q, within(1)), "within 1");
  // The largest allowed sample count, which is too small.
  for (const std::uint64_t most : {64U, 256U, 1024U}) {
    TileSettings settings = within(0.01);
    settings.target->max_samples = most;
    expect_covered_at_least(coverage_of(q, settings), std::to_string(most) + " samples");
  }
  for (const std::uint32_t each : {8U, 128U, 1024U})
    if (each < 1024 || has_time_for_large_counts())
      expect_covered_at_least(coverage_of(q, {.samples_per_block = each, .block_count = 8}),
                              std::to_string(each) + " samples a block");
}

TEST(RenderTarget, IsReached) {
  for (const PixelQuestion& q : {lamp_pixel(), edge_pixel(), furnace_pixel()}) {
    std::vector<Answer> answers(target_repeats());
    tbb::parallel_for(std::size_t{0}, answers.size(), [&](std::size_t i) {
      answers[i] = answer(q, within(kTargetRelative), 5000 + i);
    });
    expect_reached(
        q.truth, [&](std::size_t i) { return answers[i].value; }, q.name);
  }
}

}  // namespace
}  // namespace lucerna::testing
