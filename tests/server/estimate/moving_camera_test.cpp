// A camera that moves, from scene file to picture.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "server/estimate/render.h"
#include "tests/server/estimate/tiles.h"
#include "tests/server/pbrt/pbrt_fixture.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<const Scene> scene_of_text(const std::string& text) {
  auto description = load_text(text);
  if (!description.ok()) throw std::runtime_error(message(description.status()));
  EXPECT_EQ(remarks_of(*description), "");
  return build(*std::move(description));
}

void expect_near(const Vec3f& a, const Vec3& b, double tolerance) {
  EXPECT_LE(length(Vec3(a) - b), tolerance)
      << a.x << " " << a.y << " " << a.z << " against " << b.x << " " << b.y << " " << b.z;
}

constexpr char kFilm[] = "Film \"rgb\" \"integer xresolution\" 20 \"integer yresolution\" 20 ";
constexpr char kCamera[] = "Camera \"perspective\" \"float fov\" 90 WorldBegin ";

TEST(MovingCamera, TurnsHalfwayInHalfTheTime) {
  // The camera looks along +z, +x right, +y up.  The world turns about +z by 90 degrees, from +x to
  // +y, so the camera turns the other way.
  const auto scene = scene_of_text(std::string(kFilm) +
                                   "TransformTimes 1 3 ActiveTransform EndTime Rotate 90 0 0 1 "
                                   "ActiveTransform All " +
                                   kCamera);
  const Camera& camera = scene->camera();
  const double s = std::sqrt(0.5);
  // The middle of the right edge: 45 degrees from the axis.
  for (const auto& [t, right] : {std::pair{-7.0, Vec3{1, 0, 0}},
                                 {1.0, {1, 0, 0}},
                                 {2.0, {s, -s, 0}},
                                 {3.0, {0, -1, 0}},
                                 {9.0, {0, -1, 0}}}) {
    expect_near(camera.ray(20, 10, t).direction, (right + Vec3{0, 0, 1}) * s, 1e-7);
    expect_near(camera.ray(10, 10, t).direction, {0, 0, 1}, 1e-7);
    EXPECT_EQ(camera.ray(10, 10, t).time_s, t);
    expect_near(camera.ray(10, 10, t).origin, {}, 0);
  }
}

TEST(MovingCamera, MovesAlongAStraightLine) {
  // The world turns by 90 degrees before a camera 6 m from its zero.  The camera moves from (0, -6,
  // 0) to (-6, 0, 0) along the chord, like in pbrt-v4: 6 / sqrt 2 from zero in the middle.  A
  // turning world would keep it on the circle.
  const auto scene = scene_of_text(std::string(kFilm) +
                                   "LookAt 0 -6 0  0 0 0  0 0 1 ActiveTransform EndTime "
                                   "Rotate 90 0 0 1 ActiveTransform All " +
                                   kCamera);
  const Camera& camera = scene->camera();
  expect_near(camera.ray(10, 10, 0).origin, {0, -6, 0}, 0);
  expect_near(camera.ray(10, 10, 0.5).origin, {-3, -3, 0}, 1e-6);
  expect_near(camera.ray(10, 10, 1).origin, {-6, 0, 0}, 1e-6);
  const double s = std::sqrt(0.5);
  expect_near(camera.ray(10, 10, 0.5).direction, {s, s, 0}, 1e-7);
  expect_near(camera.ray(10, 10, 1).direction, {1, 0, 0}, 1e-7);
}

/// A camera moves from x = -1 to 1 in a second.  At 4 m is a strip of luminance 3, from x = 0 to
/// 0.5.
SceneDescription passing() {
  SceneDescription d = description();
  d.shapes.push_back(emissive(patch({0, -9, 4}, {0.5, -9, 4}, {0, 9, 4}, {0.5, 9, 4}), 3, true));
  d.film = {.width = 20, .height = 2};
  d.camera.world_from_camera = *Transform::look_at({-1, 0, 0}, {-1, 0, 1}, {0, 1, 0});
  d.camera.screen_min = {-1, -0.1};
  d.camera.screen_max = {1, 0.1};
  const KeyTransform keys[] = {{0, d.camera.world_from_camera},
                               {1, *Transform::look_at({1, 0, 0}, {1, 0, 1}, {0, 1, 0})}};
  d.camera.motion = std::make_shared<const Motion>(*Motion::create(keys));
  d.hints.shutter_close_s = 1;
  return d;
}

/// The share of the time from `open` to `close` in which the strip is visible at the tangent `s`.
/// The condition is 0 <= -1 + 2 t + 4 s <= 0.5.
double seen(double s, double open, double close) {
  const double begin = std::max(open, (1 - 4 * s) / 2), end = std::min(close, (1.5 - 4 * s) / 2);
  return std::max(0.0, end - begin) / (close - open);
}

void expect_streak(const TileResult& tile, std::uint64_t blocks, double open, double close) {
  const auto n = static_cast<double>(blocks);
  for (std::size_t pixel = 0; pixel < 40; ++pixel) {
    // The mean over the pixel, by midpoints of a piecewise linear function.
    constexpr int kSteps = 10000;
    double expected = 0;
    for (int k = 0; k < kSteps; ++k)
      expected +=
          3.0 / kSteps *
          seen(-1 + 0.1 * (static_cast<double>(pixel % 20) + (k + 0.5) / kSteps), open, close);
    const BlockStatistics& b = tile.channels[3 * pixel];
    // Seven standard errors for 40 pixels, exceeded by chance less than once in 1e9.
    EXPECT_NEAR(b.sum / n, expected, 7 * std::sqrt(b.deviation / (n * (n - 1))) + 1e-5)
        << pixel << " from " << open << " to " << close;
    if (expected == 0) {
      EXPECT_EQ(b.sum, 0);
    }
  }
}

TEST(MovingCamera, BlursObjectsThatItPasses) {
  const auto scene = build(passing());
  TileSettings s{.rect = {0, 0, 20, 2}, .samples_per_block = 64, .block_count = 256, .bounces = 0};
  const TileResult streak = render_tile(*scene, s, {});
  expect_streak(streak, 256, 0, 1);
  EXPECT_NEAR(streak.channels[3 * 10].sum / 256, 0.75, 0.05);  // a quarter of the time
  s.shutter = Shutter{0.5, 0.75};
  expect_streak(render_tile(*scene, s, {}), 256, 0.5, 0.75);
}

TEST(MovingCamera, BlurIsTheMeanOverTime) {
  SceneDescription d = passing();
  d.lights.push_back(point_light({0, 0, 1}, 10));
  d.shapes.push_back(patch({-9, -9, 5}, {9, -9, 5}, {-9, 9, 5}, {9, 9, 5}));
  const auto scene = build(d);
  TileSettings s{
      .rect = {0, 0, 20, 2}, .seed = 3, .samples_per_block = 4, .block_count = 1024, .bounces = 0};
  // The midpoint rule adds an error.  A pixel is 0.4 m wide.  Its view of the strip is linear in
  // time between four kinks, with slopes up to 3 in 0.2 s.  The rule misses each kink by at most an
  // eighth of a squared step.
  expect_mean_of_moments(render_tile(*scene, s, {}), *scene, s, 64,
                         4 * 15 / (8.0 * kMoments * kMoments));
}

TEST(MovingCamera, ShowsTheStillPictureOfItsFirstMoment) {
  SceneDescription d = passing();
  const auto moves = build(d);
  d.camera.motion = nullptr;
  const auto still = build(d);
  EXPECT_TRUE(moves->moves());
  EXPECT_FALSE(still->moves());
  EXPECT_EQ(still->camera().motion(), nullptr);
  const TileSettings s{
      .rect = {0, 0, 20, 2}, .samples_per_block = 4, .block_count = 4, .time_s = 0};
  expect_part(render_tile(*moves, s, {}), s.rect, render_tile(*still, s, {}), 20);
}

TEST(MovingCamera, GivesTheSameBitsForAnyTiling) {
  const auto scene = build(passing());
  TileSettings s{.rect = {0, 0, 20, 2}, .seed = 9, .samples_per_block = 4, .block_count = 8};
  const TileResult all = render_tile(*scene, s, {});
  for (const PixelRect& r : {PixelRect{0, 0, 7, 2}, {7, 0, 20, 1}, {7, 1, 20, 2}}) {
    s.rect = r;
    expect_part(render_tile(*scene, s, {}), r, all, 20);
  }
}

TEST(MovingCamera, MovesObjectsInItsCoordinates) {
  // The camera moves and turns.  Its coordinate system places two plates in front of it.  (An
  // object with a zero of its own would move straight from end to end, as in pbrt-v4.)
  const auto scene = scene_of_text(
      std::string(kFilm) +
      "ActiveTransform StartTime LookAt 1 -6 2  0 0 1  0 0 1 ActiveTransform EndTime "
      "LookAt -7 3 4  0 1 0  0.2 0 1 ActiveTransform All " +
      kCamera +
      "CoordSysTransform \"camera\" "
      "Shape \"bilinearmesh\" \"point3 P\" [0.2 -0.5 3 1.2 -0.5 3.5 0.2 0.7 3 1.2 0.7 3.5] "
      "Shape \"bilinearmesh\" \"point3 P\" [-9 -9 4 -0.6 -9 4 -9 9 4 -0.6 9 4]");
  int hits = 0, misses = 0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const auto at = [&](double t) {
        return scene->closest_hit(scene->camera().ray(float(x) + 0.43F, float(y) + 0.61F, t));
      };
      const auto first = at(0);
      ++(first ? hits : misses);
      for (const double t : {0.25, 0.7, 1.0}) {
        const auto now = at(t);
        ASSERT_EQ(now.has_value(), first.has_value()) << x << " " << y << " at " << t;
        if (now) {
          EXPECT_NEAR(now->t, first->t, 1e-4) << x << " " << y << " at " << t;
        }
      }
    }
  }
  EXPECT_GT(hits, 100);
  EXPECT_GT(misses, 100);
}

TEST(MovingCamera, KeepsItsPathFarFromTheWorldsZero) {
  // All numbers are exact in double precision at both places, and so are the scenes' origins.
  const auto about = [](const Vec3& o) {
    const auto at = [&](double x, double y, double z) {
      return fmt::format("{} {} {} ", o.x + x, o.y + y, o.z + z);
    };
    return scene_of_text(std::string(kFilm) + "ActiveTransform StartTime LookAt " +
                         at(0.25, -6.5, 2) + at(0, 0, 1) + "0 0 1 ActiveTransform EndTime LookAt " +
                         at(-5, 3.125, 2) + at(0, 1, 1) + "0 0 1 ActiveTransform All " + kCamera +
                         "Shape \"bilinearmesh\" \"point3 P\" [" + at(-4, -4, 0) + at(4, -4, 0) +
                         at(-4, 4, 0) + at(4, 4, 0) + "]");
  };
  const auto near = about({}), far = about({1e7, -2e7, 3e6});
  EXPECT_EQ(far->origin(), Vec3(1e7, -2e7, 3e6));
  for (const double t : {0.0, 0.3, 0.85, 1.0}) {
    for (const float x : {0.0F, 3.5F, 20.0F}) {
      EXPECT_EQ(near->camera().ray(x, 7, t).origin, far->camera().ray(x, 7, t).origin) << t;
      EXPECT_EQ(near->camera().ray(x, 7, t).direction, far->camera().ray(x, 7, t).direction) << t;
    }
  }
}

TEST(MovingCamera, UsesTheTransformTimesBeforeIt) {
  const char* moving =
      "ActiveTransform EndTime Translate 0 0 -2 ActiveTransform All Camera \"perspective\" ";
  const auto before = load_text(std::string("TransformTimes 0.5 2 ") + moving + "WorldBegin");
  ASSERT_TRUE(before.ok());
  ASSERT_NE(before->camera.motion, nullptr);
  const auto frames = before->camera.motion->key_frames();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].time_s, 0.5);
  EXPECT_EQ(frames[1].time_s, 2);
  EXPECT_EQ(frames[1].position_m, Vec3(0, 0, 2));
  // As in pbrt-v4: directives after the camera apply to later objects only.
  const auto after = load_text(std::string(moving) + "TransformTimes 0.5 2 WorldBegin");
  ASSERT_TRUE(after.ok());
  EXPECT_EQ(after->camera.motion->key_frames()[0].time_s, 0);
  EXPECT_EQ(after->camera.motion->key_frames()[1].time_s, 1);
  const auto still = load_text("Translate 0 0 -2 Camera \"perspective\" WorldBegin");
  EXPECT_EQ(still->camera.motion, nullptr);
}

TEST(MovingCamera, AMotionThatIsNotRigidIsAnError) {
  for (const char* bad : {"Scale 2 2 2", "Scale -1 1 1", "Scale 1 2 1",
                          "ConcatTransform [1 0 0 0  0.5 1 0 0  0 0 1 0  0 0 0 1]"})
    EXPECT_THAT(error_of(std::string("ActiveTransform EndTime ") + bad +
                         " ActiveTransform All\n Camera \"perspective\" WorldBegin"),
                HasSubstr("scene.pbrt:2:2: Camera: motion that scales or shears (key frame 2 "
                          "against the first), allowed: rotations and translations"))
        << bad;
  EXPECT_THAT(error_of("TransformTimes 2 1 ActiveTransform EndTime Translate 1 0 0\n"
                       "Camera \"perspective\" WorldBegin"),
              HasSubstr("scene.pbrt:2:1: Camera: motion.time_s = 1 of key frame 2, allowed: finite "
                        "and ascending"));
  EXPECT_THAT(error_of("ActiveTransform EndTime\nScale 0 1 1 Camera \"perspective\" WorldBegin"),
              HasSubstr("scene.pbrt:2:1: Scale"));
  // A camera that is always mirrored or scaled is valid.
  EXPECT_EQ(error_of("Scale -1 2 1 ActiveTransform EndTime Translate 1 0 0 ActiveTransform All "
                     "Camera \"perspective\" WorldBegin"),
            "");
}

TEST(MovingCamera, IsListedAmongTheScenesParts) {
  SceneDescription d = passing();
  const auto why = [](const Scene& scene) {
    for (const ScenePart& p : scene.parts())
      if (p.name == "motion") return p.why;
    return std::string();
  };
  EXPECT_EQ(why(*build(d)), "0 lights, 0 shapes and instances and the camera move");
  d.camera.motion = nullptr;
  EXPECT_EQ(why(*build(d)), "");
}

}  // namespace
}  // namespace lucerna::testing
