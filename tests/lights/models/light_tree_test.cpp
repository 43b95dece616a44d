#include "lights/models/light_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lights/maths/vec.h"
#include "tests/lights/local_lights.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

/// A light that emits equally in all directions from one point.
LightTree::Item lamp(const Vec3& at, double power = 1) {
  return {{.lower = at, .upper = at, .cone_rad = kPi}, power};
}
/// A square of 1 m about `at` that emits downwards by the cosine.
LightTree::Item panel(const Vec3& at, double power = 1) {
  return {{.lower = at - Vec3{0.5, 0.5, 0},
           .upper = at + Vec3{0.5, 0.5, 0},
           .axis = {0, 0, -1},
           .cone_rad = kPi / 2,
           .normals_rad = 0},
          power};
}

Vec3 random_point(RandomU& random, double size) {
  const auto number = [&] { return size * (2.0 * random.next() - 1); };
  return {number(), number(), number()};
}
/// A random number with 48 bits.
double random_u(RandomU& random) { return double{random.next()} + double{random.next()} * 0x1p-24; }

double sum_of_probabilities(const LightTree& tree, std::uint32_t count, const Receiver& receiver) {
  double sum = 0;
  for (std::uint32_t i = 0; i < count; ++i) sum += tree.probability(receiver, i);
  return sum;
}

TEST(LightTree, ProbabilitiesOfLightsThatReachEverywhereSumToOne) {
  RandomU random(1);
  for (const std::uint32_t count : {1u, 2u, 3u, 17u, 1000u}) {
    std::vector<LightTree::Item> lamps;
    for (std::uint32_t i = 0; i < count; ++i)
      lamps.push_back(lamp(random_point(random, 1), std::exp(10.0 * random.next())));
    const LightTree tree = *LightTree::create(lamps);
    EXPECT_EQ(tree.size(), count);
    for (int i = 0; i < 20; ++i) {
      const Receiver receiver(random_point(random, 2));
      EXPECT_NEAR(sum_of_probabilities(tree, count, receiver), 1, 1e-12);
    }
  }
}

TEST(LightTree, ChoosesWithItsReportedProbabilities) {
  RandomU random(2);
  constexpr int kSamples = 20000;
  for (int scene = 0; scene < 3; ++scene) {
    std::vector<LocalLight> lights;
    for (int i = 0; i < 4; ++i)
      for (LocalLight& l : LocalLights(random_place(random, 1, 5)).take())
        lights.push_back(std::move(l));
    const LightTree tree = tree_of(lights);
    for (int r = 0; r < 5; ++r) {
      Receiver receiver(random_point(random, 6));
      if (r % 2 == 1) receiver.normal = normalized(random_point(random, 1));
      std::vector<double> chosen(lights.size() + 1), expected(lights.size() + 1);
      double none = 1;
      for (std::uint32_t i = 0; i < lights.size(); ++i) {
        expected[i] = kSamples * tree.probability(receiver, i);
        none -= tree.probability(receiver, i);
      }
      expected.back() = std::fmax(0, kSamples * none);
      for (int i = 0; i < kSamples; ++i) {
        const auto choice = tree.choose(receiver, random_u(random));
        ++chosen[choice ? choice->light : lights.size()];
        if (choice) {
          ASSERT_EQ(choice->probability, tree.probability(receiver, choice->light));
          ASSERT_GT(choice->probability, 0);
        }
      }
      EXPECT_GT(chi_square_p_value(chosen, expected), 1e-8);
      // The companion: equal probabilities would be noticed.
      std::ranges::fill(expected, double(kSamples) / double(expected.size()));
      EXPECT_LT(chi_square_p_value(chosen, expected), 1e-8);
    }
  }
}

TEST(LightTree, TwoLampsShareByIntensityOverSquaredDistance) {
  const LightTree tree = *LightTree::create(std::vector{lamp({0, 0, 3}, 2), lamp({4, 0, 0}, 7)});
  const double first = 2.0 / 9, second = 7.0 / 16;
  EXPECT_NEAR(tree.probability(Vec3{}, 0), first / (first + second), 1e-6);
  // Under the first lamp, at 60 degrees from facing it; the second one is on the horizon.
  Receiver tilted(Vec3{});
  tilted.normal = {std::sin(kPi / 3), 0, std::cos(kPi / 3)};
  const double near = first * std::cos(kPi / 3), far = second * std::sin(kPi / 3);
  EXPECT_NEAR(tree.probability(tilted, 0), near / (near + far), 1e-6);
}

TEST(LightTree, ASpotCountsByItsIntensityWithinItsConeOnly) {
  LightTree::Item spot = lamp({0, 0, 2}, 1);
  spot.bounds.axis = {0, 0, -1};
  spot.bounds.cone_rad = spot.bounds.normals_rad = 0.1;
  const LightTree tree = *LightTree::create(std::vector{spot, lamp({0, 0, -2}, 1)});
  // One lumen over the solid angle 2 pi (1 - cos 0.1) of the cone against one over 4 pi.
  const double cone = 2 * kPi * (1 - std::cos(0.1));
  EXPECT_NEAR(tree.probability(Vec3{}, 0), (1 / cone) / (1 / cone + 1 / (4 * kPi)), 1e-5);
  EXPECT_EQ(tree.probability(Vec3{2, 0, 0}, 0), 0);
  EXPECT_EQ(tree.probability(Vec3{2, 0, 0}, 1), 1);
}

TEST(LightTree, LeavesOutLightsThatCannotReachTheReceiver) {
  // A ceiling of panels.  1 m above it is within the sphere about it, but behind it.
  std::vector<LightTree::Item> panels;
  for (int i = 0; i < 64; ++i) panels.push_back(panel({2.0 * (i % 8), 2.0 * (i / 8), 3}));
  const LightTree tree = *LightTree::create(panels);
  EXPECT_FALSE(tree.choose(Vec3{7, 7, 4}, 0.5).has_value());
  EXPECT_EQ(sum_of_probabilities(tree, 64, Vec3{7, 7, 4}), 0);
  Receiver floor(Vec3{7, 7, 0});
  floor.normal = {0, 0, 1};
  EXPECT_NEAR(sum_of_probabilities(tree, 64, floor), 1, 1e-12);
  floor.normal = {0, 0, -1};
  EXPECT_FALSE(tree.choose(floor, 0.5).has_value());
  // Facing the wall at x = 7: lights behind the receiver are not chosen.
  floor.normal = {1, 0, 0};
  for (std::uint32_t i = 0; i < 64; ++i)
    EXPECT_EQ(tree.probability(floor, i) > 0, 2 * (i % 8) + 0.5 > 7) << i;
}

TEST(LightTree, LightsWithoutPowerAreLeftOutUnlessNoneHasPower) {
  const LightTree some =
      *LightTree::create(std::vector{lamp({0, 0, 1}, 0), lamp({0, 0, 2}, 5), lamp({0, 0, 3}, 0)});
  EXPECT_EQ(some.size(), 1u);
  EXPECT_EQ(some.probability(Vec3{}, 0), 0);
  EXPECT_EQ(some.choose(Vec3{}, 0.999)->light, 1u);
  EXPECT_EQ(some.choose(Vec3{}, 0.999)->probability, 1);
  const LightTree all = *LightTree::create(std::vector{lamp({0, 0, 1}, 0), lamp({0, 0, -1}, 0)});
  EXPECT_NEAR(all.probability(Vec3{}, 1), 0.5, 1e-6);
}

TEST(LightTree, LightsAtOnePlaceAreChosenByPower) {
  std::vector<LightTree::Item> lamps(100, lamp({1, 2, 3}, 1));
  lamps[37].power = 101;
  const LightTree tree = *LightTree::create(lamps);
  for (std::uint32_t i = 0; i < 100; ++i)
    EXPECT_NEAR(tree.probability(Vec3{}, i), i == 37 ? 101. / 200 : 1. / 200, 1e-6);
}

TEST(LightTree, ReceiversThatAreNotFiniteChooseNoLight) {
  const LightTree tree = *LightTree::create(std::vector{lamp({0, 0, 1}), lamp({0, 1, 1})});
  EXPECT_FALSE(tree.choose(Vec3{NAN, 0, 0}, 0.5).has_value());
  EXPECT_EQ(tree.probability(Vec3{0, INFINITY, 0}, 0), 0);
  // The largest and the smallest numbers choose a light.
  for (const double x : {1e308, 1e160, 1e-160, 5e-324, 0.})
    EXPECT_NEAR(sum_of_probabilities(tree, 2, Vec3{x, 0, -x}), 1, 1e-12) << x;
  EXPECT_FALSE(LightTree::create({})->choose(Vec3{}, 0.5).has_value());
}

TEST(LightTree, ErrorsNameTheInvalidLight) {
  const auto error = [](const LightTree::Item& item) {
    return std::string(LightTree::create(std::vector{lamp({}), item}).status().message());
  };
  EXPECT_THAT(error(lamp({}, -1)), HasSubstr("power -1 of light 1, allowed: finite"));
  EXPECT_THAT(error(lamp({}, INFINITY)), HasSubstr("power inf of light 1"));
  EXPECT_THAT(error(lamp({NAN, 0, 0})), HasSubstr("bounds of light 1, allowed: finite"));
  LightTree::Item turned = lamp({});
  turned.bounds.cone_rad = NAN;
  EXPECT_THAT(error(turned), HasSubstr("bounds of light 1"));
}

/// The second moment of one sample's estimate of the illuminance of all `lights`, over its square.
/// It is computed for the tree and for choice by power.  Without variance it would be 1.  The mean
/// of 50 receivers that face up.
struct SecondMoments {
  double by_tree = 0, by_power = 0;
};
template <typename Place>
SecondMoments second_moments(const std::vector<LightTree::Item>& lights, Place&& place) {
  const LightTree tree = *LightTree::create(lights);
  double total = 0;
  for (const LightTree::Item& l : lights) total += l.power;
  SecondMoments mean;
  constexpr int kReceivers = 50;
  for (int r = 0; r < kReceivers; ++r) {
    Receiver receiver(place());
    receiver.normal = {0, 0, 1};
    double sum = 0, tree_square = 0, power_square = 0;
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
      const LightBounds& b = lights[i].bounds;
      const Vec3 way = (b.lower + b.upper) * 0.5 - receiver.position;
      const double d = length(way), cos = way.z / d;
      // Panels face down, and the receiver faces up.
      const double lx = lights[i].power * cos / (d * d) * (b.normals_rad < b.cone_rad ? cos : 1);
      if (!(lx > 0)) continue;
      sum += lx;
      tree_square += lx * lx / tree.probability(receiver, i);
      power_square += lx * lx / (lights[i].power / total);
    }
    mean.by_tree += tree_square / (sum * sum) / kReceivers;
    mean.by_power += power_square / (sum * sum) / kReceivers;
  }
  return mean;
}

TEST(LightTree, VariesLessThanChoiceByPower) {
  RandomU random(4);
  const auto length = [&](double most) { return most * random.next(); };
  std::vector<LightTree::Item> street, ceiling, cube;
  for (int i = 0; i < 4096; ++i) {
    street.push_back(lamp({5.0 * (i % 2048), i < 2048 ? 0. : 12, 6}, i % 7 == 0 ? 3 : 1));
    ceiling.push_back(panel({2.0 * (i % 64), 2.0 * (i / 64), 3}));
    cube.push_back(lamp({length(100), length(100), length(100)}, i % 50 == 0 ? 20 : 1));
  }
  const SecondMoments in_street = second_moments(street, [&] {
    return Vec3{length(10000), length(12), 0};
  });
  EXPECT_LT(in_street.by_tree, 2);
  EXPECT_GT(in_street.by_power, 200);
  const SecondMoments under_ceiling = second_moments(ceiling, [&] {
    return Vec3{length(128), length(128), 0.8};
  });
  EXPECT_LT(under_ceiling.by_tree, 3);
  EXPECT_GT(under_ceiling.by_power, 100);
  const SecondMoments in_cube = second_moments(cube, [&] {
    return Vec3{length(100), length(100), length(50)};
  });
  EXPECT_LT(in_cube.by_tree, 3);
  EXPECT_GT(in_cube.by_power, 5);
  // Each of them beside the other, for developers who change the tree.
  RecordProperty("second_moments",
                 fmt::format("street {:.3g} {:.3g}, ceiling {:.3g} {:.3g}, cube {:.3g} {:.3g}",
                             in_street.by_tree, in_street.by_power, under_ceiling.by_tree,
                             under_ceiling.by_power, in_cube.by_tree, in_cube.by_power));
}

}  // namespace
}  // namespace lucerna::testing
