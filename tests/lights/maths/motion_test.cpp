#include "lights/maths/motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lights/maths/vec.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;
Transform turned(double angle_rad, const Vec3& axis, const Vec3& position) {
  return Transform::translate(position) * *Transform::rotate(angle_rad, axis);
}

double apart(const Vec3& a, const Vec3& b) { return length(a - b); }

TEST(Motion, MovesTheOriginInALineAndTurnsAtConstantSpeed) {
  // A quarter turn about +z while the origin moves from (1, 0, 0) to (1, 4, 0).
  const std::vector<KeyTransform> keys{{2, turned(0, {0, 0, 1}, {1, 0, 0})},
                                       {4, turned(kPi / 2, {0, 0, 1}, {1, 4, 0})}};
  const Motion motion = *Motion::create(keys);
  // One metre from the origin along x at the start; halfway in time at 45 degrees.
  const Vec3 p{2, 0, 0};
  const double s = std::sqrt(0.5);
  EXPECT_EQ(motion.at(2), Pose{});
  EXPECT_LE(apart(motion.at(3).point(p), {1 + s, 2 + s, 0}), 1e-15);
  EXPECT_LE(apart(motion.at(2.5).point(p), {1 + std::cos(kPi / 8), 1 + std::sin(kPi / 8), 0}),
            1e-15);
  EXPECT_LE(apart(motion.at(4).point(p), {1, 5, 0}), 1e-15);
}

TEST(Motion, RestsBeforeItsFirstAndAfterItsLastKeyFrame) {
  const std::vector<KeyTransform> keys{{0, {}}, {1, turned(1, {1, 2, 3}, {4, 5, 6})}};
  const Motion motion = *Motion::create(keys);
  EXPECT_EQ(motion.at(-7), Pose{});
  EXPECT_EQ(motion.at(-1e308), motion.at(0));
  EXPECT_EQ(motion.at(1e308), motion.at(1));
  EXPECT_NE(motion.at(0.5), motion.at(1));
}

TEST(Motion, PassesThroughAllOfItsKeyFrames) {
  const std::vector<KeyTransform> keys{{0, turned(0.3, {1, 0, 2}, {1, 2, 3})},
                                       {1, turned(3.1, {1, 2, 3}, {-4, 5, 6})},
                                       {5, turned(-2.5, {0, 2, -3}, {7, 7, 0})},
                                       {6, turned(kPi, {0, 1, 0}, {1, 2, 3})}};
  const Motion motion = *Motion::create(keys);
  for (const KeyTransform& key : keys) {
    const Transform relative = key.world_from_light * keys[0].world_from_light.inverse();
    for (const Vec3& p : {Vec3{0, 0, 0}, {10, 0, 0}, {1, -20, 3}}) {
      const Pose at = motion.at(key.time_s);
      EXPECT_LE(apart(at.point(p), relative.point(p)), 1e-13);
      EXPECT_LE(apart(at.inverse_point(at.point(p)), p), 1e-13);
      // Just before the key frame it is near: a metre and a radian do not jump within 1e-9 of a
      // second.
      const Pose before = motion.at(key.time_s - 1e-9);
      EXPECT_LE(apart(before.point(p), at.point(p)), 1e-6);
    }
  }
}

TEST(Motion, KeepsLengthsAndHandednessAtEveryTime) {
  // The length of a unit quaternion is 1 to within 2 eps, its square to within 4 eps.  Entries have
  // 4 eps more, and three products of them add up.
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  const std::vector<KeyTransform> keys{{0, turned(0.3, {1, 0, 2}, {1, 2, 3})},
                                       {1, turned(3.1, {1, 2, 3}, {-4, 5, 6})},
                                       {2, turned(-3, {1, 2, 3}, {-4, 5, 6})}};
  const Motion motion = *Motion::create(keys);
  for (int i = 0; i <= 100; ++i) {
    const Pose::Rotation r = motion.at(0.02 * i).r;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) EXPECT_NEAR(dot(r[a], r[b]), a == b ? 1 : 0, kRounding);
    }
    EXPECT_NEAR(dot(cross(r[0], r[1]), r[2]), 1, kRounding);
  }
}

TEST(Motion, TakesTheShorterWay) {
  // 350 degrees are 10 degrees back.
  const std::vector<KeyTransform> keys{{0, {}}, {1, turned(350 * kPi / 180, {0, 0, 1}, {})}};
  const Motion motion = *Motion::create(keys);
  const double half = -5 * kPi / 180;
  EXPECT_LE(apart(motion.at(0.5).vector({1, 0, 0}), {std::cos(half), std::sin(half), 0}), 1e-14);
  const auto [angle, axis] = motion.key_frames()[1].angle_and_axis();
  EXPECT_NEAR(angle, 10 * kPi / 180, 1e-14);
  EXPECT_LE(apart(axis, {0, 0, -1}), 1e-13);
}

TEST(Motion, ScaleCommonToAllKeyFramesIsNotMotion) {
  const Transform small = *Transform::scale({1e-3, 2e-3, -5});
  const std::vector<KeyTransform> keys{{0, turned(0.3, {1, 0, 2}, {1, 2, 3}) * small},
                                       {1, turned(1.1, {1, 2, 3}, {-4, 5, 6}) * small}};
  const auto motion = Motion::create(keys);
  ASSERT_TRUE(motion.ok()) << motion.status();
  const Transform relative = keys[1].world_from_light * keys[0].world_from_light.inverse();
  EXPECT_LE(apart(motion->at(1).point({1, 1, 1}), relative.point({1, 1, 1})), 1e-12);
}

TEST(Motion, OtherCoordinatesAreTheSameMotion) {
  const std::vector<KeyTransform> keys{{0, turned(0.3, {1, 0, 2}, {100, 2, 3})},
                                       {1, turned(3, {1, 2, 3}, {-40, 5, 6})}};
  const Motion world = *Motion::create(keys);
  const Vec3 from{90, 1, 2}, to{-30, 0, 5}, p{100.5, 1.5, 3};
  const Motion moved = world.about(from, to);
  for (const double t : {0.0, 0.4, 1.0}) {
    EXPECT_LE(apart(moved.at(t).point(p - from), world.at(t).point(p) - to), 1e-12);
  }
  EXPECT_EQ(world.about({}, {}).at(0), Pose{});
}

TEST(Motion, BoundsHoldTheSweptBox) {
  const std::vector<std::vector<KeyTransform>> motions{
      {{0, {}}, {1, turned(kPi - 0.01, {0, 0, 1}, {})}},
      {{0, turned(0.3, {1, 0, 2}, {1, 2, 3})}, {1, turned(3.1, {1, 2, 3}, {-4, 5, 6})}},
      {{0, {}}, {1, turned(0, {0, 0, 1}, {1e6, 0, 0})}},
      {{0, {}}, {1, turned(2, {1, 1, 0}, {0, 1, 0})}, {3, turned(-2, {0, 1, 5}, {3, 3, 3})}}};
  const Vec3 lower{1, -0.5, 2}, upper{1.5, 4, 2};
  for (const auto& keys : motions) {
    const Motion motion = *Motion::create(keys);
    const auto [low, high] = motion.bounds(lower, upper);
    RandomU random(7);
    Vec3 least{1e300, 1e300, 1e300}, most{-1e300, -1e300, -1e300};
    for (int i = 0; i <= 3000; ++i) {
      const Pose pose = motion.at(keys.back().time_s * i / 3000);
      for (int c = 0; c < 9; ++c) {
        const auto pick = [&](int bit, double a, double b) {
          return c == 8 ? a + (b - a) * random.next() : (c >> bit & 1) != 0 ? b : a;
        };
        const Vec3 p = pose.point(
            {pick(0, lower.x, upper.x), pick(1, lower.y, upper.y), pick(2, lower.z, upper.z)});
        least = {std::fmin(least.x, p.x), std::fmin(least.y, p.y), std::fmin(least.z, p.z)};
        most = {std::fmax(most.x, p.x), std::fmax(most.y, p.y), std::fmax(most.z, p.z)};
      }
    }
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(low[a], least[a]);
      EXPECT_GE(high[a], most[a]);
      // At most the padding of 1/2048 of a reach of 8 m, plus the gaps between 3000 steps.
      EXPECT_GE(low[a], least[a] - 0.01);
      EXPECT_LE(high[a], most[a] + 0.01);
    }
  }
}

TEST(Motion, RefusesMotionsThatAreNotRigid) {
  const auto message = [](std::vector<KeyTransform> keys) {
    const auto motion = Motion::create(keys);
    EXPECT_EQ(motion.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(motion.status().message());
  };
  EXPECT_THAT(message({{0, {}}}), HasSubstr("motion of 1 key frames, allowed: 2 or more"));
  EXPECT_THAT(message({{0, {}}, {0, {}}}),
              HasSubstr("motion.time_s = 0 of key frame 2, allowed: finite and ascending"));
  EXPECT_THAT(message({{0, {}}, {NAN, {}}}), HasSubstr("motion.time_s = nan"));
  EXPECT_THAT(message({{0, {}}, {1, *Transform::scale({1, 1, 1.00001})}}),
              HasSubstr("motion that scales or shears"));
  EXPECT_THAT(message({{0, {}}, {1, *Transform::scale({1, 1, -1})}}),
              HasSubstr("motion that scales or shears"));
  EXPECT_THAT(
      message(
          {{0, {}}, {1, *Transform::from_matrix({{{1, 1e-4, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}})}}),
      HasSubstr("motion that scales or shears"));
  const std::vector<KeyTransform> rounded{
      {0, {}}, {1, *Transform::from_matrix({{{1, 1e-7, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}})}};
  EXPECT_TRUE(Motion::create(rounded).ok());
}

}  // namespace
}  // namespace lucerna::testing
