// Pixels whose samples say little: beside edges, and in light that few samples find.
#include <gtest/gtest.h>

#include <boost/math/distributions/students_t.hpp>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "lights/maths/rgb.h"
#include "server/estimate/render.h"
#include "tests/extremes_sweep.h"
#include "tests/lights/closed_forms.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

using std::numbers::pi;

constexpr std::uint32_t kBlocks = 8;
constexpr int kSeeds = 200;
// An interval of 95% holds in fewer than 175 of 200 pictures once in 3e5 times.
constexpr int kHoldsAtLeast = 175;

/// A pixel that sees `metres` of the floor around the origin, and its converged luminance.
struct Pixel {
  std::shared_ptr<const Scene> scene;
  double truth;
};

Pixel pixel(SceneDescription d, double metres, double truth) {
  d.film = {.width = 1, .height = 1};
  d.camera.world_from_camera = *Transform::look_at({0, 0, 1}, {}, {0, 1, 0});
  d.camera.screen_min = {-metres / 2, -metres / 2};
  d.camera.screen_max = {metres / 2, metres / 2};
  return {build(std::move(d)), truth};
}

/// How many pictures have an interval that holds the converged luminance.
struct Held {
  int served = 0, student = 0;
};

Held held(const Pixel& p, std::uint32_t samples) {
  const double t = quantile(complement(boost::math::students_t(kBlocks - 1), 0.025));
  Held count;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const TileSettings settings{.rect = {0, 0, 1, 1},
                                .seed = seed,
                                .samples_per_block = samples / kBlocks,
                                .block_count = kBlocks,
                                .bounces = 0,
                                .intervals = true};
    const TileResult r = render_tile(*p.scene, settings, {});
    const FloatInterval i = pixel_intervals(r.moments, kBlocks, samples / kBlocks)[0];
    count.served += i.lower <= p.truth && p.truth <= i.upper;
    // The light is grey, so one channel is the luminance.
    const double mean = r.channels[1].sum / kBlocks;
    const double off = t * std::sqrt(r.channels[1].deviation / (kBlocks * (kBlocks - 1)));
    count.student += std::abs(p.truth - mean) <= off;
  }
  return count;
}

/// Counts the pixels of a sweep whose intervals hold too rarely.
class Tally {
 public:
  void add(const Held& h) {
    ++cases_;
    wrong_ += h.served < kHoldsAtLeast;
    student_ += h.student < kHoldsAtLeast;
  }
  void expect_none(Sweep& sweep) const {
    sweep.textbook_count(student_);
    sweep.expect_none(wrong_, cases_, 0);
  }

 private:
  std::int64_t cases_ = 0, wrong_ = 0, student_ = 0;
};

TEST(IntervalExtremes, Edges) {
  Sweep sweep(37, "pixels beside an edge", "0.1 ... 0.9 of the pixel lit; 64 and 256 samples",
              "95% interval that holds too rarely");
  Tally tally;
  for (int percent = 10; percent <= 90; ++percent) {
    const double share = percent / 100.0, end = share - 0.5;
    SceneDescription d = description(0.5);
    d.shapes = {patch({-9, -9, 0}, {end, -9, 0}, {-9, 9, 0}, {end, 9, 0})};
    d.lights = {{DistantLightParams{{0, 0, 1}, Rgb(10)}, {}}};
    const Pixel p = pixel(std::move(d), 1, share * 0.5 * 10 / pi);
    for (const std::uint32_t samples : {64U, 256U}) tally.add(held(p, samples));
  }
  tally.expect_none(sweep);
}

TEST(IntervalExtremes, Slits) {
  Sweep sweep(37, "pixels lit through a slit",
              "1e-4 ... 0.3 of the lamp visible; 64 and 1024 samples",
              "95% interval that holds too rarely");
  Tally tally;
  for (const double share : {1e-4, 3e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.03, 0.1, 0.3}) {
    // A lamp of 2 m x 2 m at 4 m, and a slit at 2 m.
    const double half = share / 2, far = 30;
    SceneDescription d = description(0.5);
    d.shapes = {floor(9.0), emissive(patch({-1, -1, 4}, {-1, 1, 4}, {1, -1, 4}, {1, 1, 4}), 100),
                patch({-far, -far, 2}, {-half, -far, 2}, {-far, far, 2}, {-half, far, 2}),
                patch({half, -far, 2}, {far, -far, 2}, {half, far, 2}, {far, far, 2})};
    const double lux =
        100 * polygon_irradiance({{-share, -1, 4}, {share, -1, 4}, {share, 1, 4}, {-share, 1, 4}},
                                 {}, {0, 0, 1});
    const Pixel p = pixel(std::move(d), 1e-3, 0.5 * lux / pi);
    for (const std::uint32_t samples : {64U, 1024U}) tally.add(held(p, samples));
  }
  tally.expect_none(sweep);
}

}  // namespace
}  // namespace lucerna::testing
