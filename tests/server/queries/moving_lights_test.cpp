// Moving objects, from the scene file to answers at a time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "server/estimate/render.h"
#include "server/queries/queries.h"
#include "tests/server/estimate/moving_shapes.h"
#include "tests/server/estimate/tiles.h"
#include "tests/server/pbrt/pbrt_fixture.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

std::vector<KeyTransform> lamp_keys() {
  return {{0, Transform::translate({0, 0, 3})},
          {2, Transform::translate({4, 0, 3}) * *Transform::rotate(1.5, {0, 1, 0})}};
}

/// 18 cd from (0, 0, 3) at 0 s to (4, 0, 3) at 2 s, above a floor with a wall at x = 2.
SceneDescription moving_point(bool moves = true) {
  SceneDescription d = description();
  d.shapes.push_back(floor(10));
  d.shapes.push_back(patch({2, -5, 0}, {2, 5, 0}, {2, -5, 1}, {2, 5, 1}));
  d.lights.push_back(point_light({0, 0, 3}, 18));
  if (moves) d.lights[0].motion = moving(lamp_keys());
  d.hints.shutter_close_s = 2;
  return d;
}

/// The camera is 4 m in front of a wall that a light passes.
SceneDescription wall() {
  SceneDescription d = description(0.8);
  d.film = {.width = 6, .height = 4};
  d.shapes.push_back(patch({-9, -9, 4}, {9, -9, 4}, {-9, 9, 4}, {9, 9, 4}));
  d.lights.push_back(point_light({-2, 0, 3}, 10));
  d.hints.shutter_close_s = 1;
  return d;
}

TEST(MovingLights, BlurIsTheMeanOverTime) {
  SceneDescription d = wall();
  d.lights[0].motion = moving({{0, {}}, {1, Transform::translate({4, 1, 0})}});
  const auto scene = build(d);
  TileSettings s{
      .rect = {0, 0, 6, 4}, .seed = 3, .samples_per_block = 4, .block_count = 256, .bounces = 0};
  const TileResult blurred = render_tile(*scene, s, {});
  const std::vector<double> mean = expect_mean_of_moments(blurred, *scene, s, 16, 0);
  // It differs from the picture at the start.
  s.time_s = 0;
  const TileResult start = render_tile(*scene, s, {});
  EXPECT_GT(std::fabs(start.channels[0].sum / 256 - mean[0]), 0.1 * mean[0]);
}

TEST(MovingLights, ScenesWithoutMotionStoreNothingForIt) {
  const auto has_motion = [](const Scene& scene) {
    for (const ScenePart& p : scene.parts())
      if (p.name == "motion") return true;
    return false;
  };
  const auto still = build(moving_point(false)), moves = build(moving_point());
  EXPECT_FALSE(has_motion(*still));
  EXPECT_FALSE(still->moves());
  EXPECT_EQ(still->lights()[0].moving, nullptr);
  EXPECT_TRUE(has_motion(*moves));
  EXPECT_TRUE(moves->moves());
  // Its answers do not depend on time: the same bits with and without one.
  const auto picture = build(wall());
  TileSettings s{.rect = {0, 0, 6, 4}, .samples_per_block = 4, .block_count = 4};
  const auto any = render_tile(*picture, s, {});
  s.time_s = 0.3;
  const auto at = render_tile(*picture, s, {});
  for (std::size_t c = 0; c < any.channels.size(); ++c) {
    EXPECT_EQ(any.channels[c].sum, at.channels[c].sum);
    EXPECT_EQ(any.channels[c].deviation, at.channels[c].deviation);
  }
}

TEST(PbrtMotion, OfALightIsReadWithItsTimesAndShutter) {
  const auto scene = load_text(R"(TransformTimes 0.5 2
    Camera "perspective" "float shutteropen" 0.25 "float shutterclose" 0.75
    WorldBegin
    Translate 1 2 3
    ActiveTransform EndTime Translate 4 0 0 Rotate 90 0 0 1 ActiveTransform All
    LightSource "point" "point3 from" [1 0 0]
    LightSource "distant")");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(remarks_of(*scene), "");
  EXPECT_EQ(scene->hints.shutter_open_s, 0.25);
  EXPECT_EQ(scene->hints.shutter_close_s, 0.75);
  ASSERT_EQ(scene->lights.size(), 2U);
  const Motion& motion = *scene->lights[0].motion;
  EXPECT_EQ(motion.key_frames()[0].time_s, 0.5);
  EXPECT_EQ(motion.key_frames()[1].time_s, 2);
  EXPECT_EQ(std::get<PointLightParams>(scene->lights[0].params).position_m, Vec3(2, 2, 3));
  // At the end the light's origin is at (5, 2, 3), and its own (1, 0, 0) is a metre along +y from
  // there.
  EXPECT_LE(length(motion.at(2).point({2, 2, 3}) - Vec3{5, 3, 3}), 1e-14);
  EXPECT_NE(scene->lights[1].motion, nullptr);
  const auto otherwise = load_world("LightSource \"point\"");
  EXPECT_EQ(otherwise->lights[0].motion, nullptr);
  EXPECT_EQ(otherwise->hints.shutter_open_s, 0);
  EXPECT_EQ(otherwise->hints.shutter_close_s, 1);
}

TEST(PbrtMotion, ThatIsNotRigidIsAnErrorForLights) {
  EXPECT_THAT(error_of("WorldBegin\nActiveTransform EndTime Scale 2 2 2\n  LightSource \"point\""),
              HasSubstr("scene.pbrt:3:3: LightSource: motion that scales or shears"));
  EXPECT_THAT(error_of("TransformTimes 1 1\nWorldBegin\nActiveTransform EndTime Translate 2 2 2\n"
                       "LightSource \"point\""),
              HasSubstr("motion.time_s = 1 of key frame 2, allowed: finite and ascending"));
}

}  // namespace
}  // namespace lucerna::testing
