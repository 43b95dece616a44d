// The coverage of pixel intervals over repeats.  Tiles with a sample count have intervals by
// Student's t and their standard error.  Tiles with a target error report their intervals.
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <boost/math/distributions/students_t.hpp>
#include <numbers>
#include <vector>

#include "server/estimate/paths/render.h"
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
void look(SceneDescription& d, const Vec3<double>& from, const Vec3<double>& at, double metres) {
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

/// The floor ends within the pixel and fills 0.3 of it.  Its light needs no sample.  The pixel is
/// large: points cover it so evenly that the rounding of floats would be noticeable.
PixelQuestion edge_pixel() {
  SceneDescription d = description(0.5);
  const double end = 0.3 - 0.5;
  d.shapes = {patch({-9, -9, 0}, {end, -9, 0}, {-9, 9, 0}, {end, 9, 0})};
  d.lights = {{DistantLightParams{{0, 0, 1}, Rgb<double>(10)}, {}}};
  look(d, {0, 0, 1}, {}, 1);
  d.camera.world_from_camera = *Transform::look_at({0, 0, 1}, {}, {0, 1, 0});
  return {"edge", build(std::move(d)), 0.3 * 0.5 * 10 / pi};
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
  const TileResult r = render_tile(*q.scene, settings, {});
  const auto n = static_cast<double>(settings.block_count);
  const auto value = [&](int c) { return r.channels[c].sum / n; };
  const double mean = luminance(Rgb<double>{value(0), value(1), value(2)});
  if (settings.target) return {mean, r.intervals[0]};
  // All of these lights are grey, so the standard error of one channel is that of the luminance.
  const double error = std::sqrt(r.channels[1].deviation / (n * (n - 1)));
  const double t = quantile(complement(boost::math::students_t(n - 1), 0.025));
  return {mean, {mean - t * error, mean + t * error}};
}

/// `widened`: factor of the intervals' width about their estimates.
Coverage coverage_of(const PixelQuestion& q, const TileSettings& settings, double widened = 1) {
  return repeated(q.truth, widened, [&](std::uint64_t i) { return answer(q, settings, i); });
}

TileSettings within(double relative) {
  return {.block_count = 32, .target = TargetError{.relative = relative}};
}

TEST(RenderCoverage, OfSmoothLightByACount) {
  // The means of 8 blocks take few values here, as beside an edge.  All are often equal.
  for (const PixelQuestion& q : {lamp_pixel(), furnace_pixel()})
    for (const std::uint32_t each : {32U, 64U})
      expect_covered(coverage_of(q, {.samples_per_block = each, .block_count = 8}),
                     q.name + ", " + std::to_string(each) + " samples a block");
  for (const std::uint32_t each : {4U, 8U, 16U})
    expect_covered(coverage_of(edge_pixel(), {.samples_per_block = each, .block_count = 32}),
                   "edge, " + std::to_string(each) + " samples a block");
}

TEST(RenderCoverage, OfSmoothLightByATarget) {
  for (const PixelQuestion& q : {lamp_pixel(), edge_pixel(), furnace_pixel()})
    for (const double relative : {0.1, 0.02})
      expect_covered(coverage_of(q, within(relative)),
                     q.name + " within " + std::to_string(relative));
  // With 64 samples, so few find the edge's light that intervals may hold it too often.
  for (const PixelQuestion& q : {lamp_pixel(), edge_pixel()})
    expect_covered_at_least(coverage_of(q, within(1)), q.name + " within 1");
}

TEST(RenderCoverage, OfLightThroughAPinhole) {
  const PixelQuestion q = pinhole_pixel();
  expect_covered_at_least(coverage_of(q, within(1)), "within 1");
  // The largest allowed sample count, which is too small.
  for (const std::uint64_t most : {64U, 256U, 1024U}) {
    TileSettings settings = within(0.01);
    settings.target->max_samples = most;
    expect_covered_at_least(coverage_of(q, settings), std::to_string(most) + " samples");
  }
  expect_covered_at_least(coverage_of(q, {.samples_per_block = 2048, .block_count = 8}),
                          "2048 samples a block");
}

// The coverage of intervals with a wrong variance.
TEST(RenderCoverage, NoticesIntervalsThatAreTooNarrowOrTooWide) {
  for (const TileSettings& settings :
       {within(0.1), TileSettings{.samples_per_block = 8, .block_count = 8}})
    expect_sees_wrong_widths(
        [&](double widened) { return coverage_of(lamp_pixel(), settings, widened); });
}

TEST(RenderTarget, IsReached) {
  for (const PixelQuestion& q : {lamp_pixel(), edge_pixel(), furnace_pixel()}) {
    std::vector<Answer> answers(kTargetQuestions);
    tbb::parallel_for(std::size_t{0}, answers.size(),
                      [&](std::size_t i) { answers[i] = answer(q, within(0.02), 5000 + i); });
    expect_reached(
        q.truth, [&](std::size_t i) { return answers[i].value; }, q.name);
  }
}

}  // namespace
}  // namespace lucerna::testing
