#include "server/scene/light_selector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "lights/sampling/sobol.h"

namespace lucerna {
namespace {

constexpr LightSelection kLightSelections[] = {LightSelection::kUniform, LightSelection::kPower,
                                               LightSelection::kBvh};

LightSelector::Item lamp(double x, double lumens) {
  const Vec3 at{x, 0, 3};
  LightBounds bounds{.lower = at, .upper = at};
  bounds.cone_rad = bounds.normals_rad = std::numbers::pi;
  return {0, lumens, 0, bounds};
}

LightSelector::Item sky(double lumens, double lux) { return {0, lumens, lux, std::nullopt}; }

/// Numbers the lights in order.
std::vector<LightSelector::Item> numbered(std::vector<LightSelector::Item> items) {
  for (std::uint32_t i = 0; i < items.size(); ++i) items[i].light = i;
  return items;
}

/// Lamps in a row, and two distant lights: one between them, one behind.
LightSelector row_of_lamps(int lamps) {
  std::vector<LightSelector::Item> items;
  for (int i = 0; i < lamps; ++i) {
    items.push_back(lamp(i, 1 + i % 3));
    if (i == lamps / 2) items.push_back(sky(1e6, 30));
  }
  items.push_back(sky(1e5, 10));
  return LightSelector(numbered(std::move(items)));
}

Receiver floor_at(double x) {
  Receiver r(Vec3{x, 0, 0});
  r.normal = {0, 0, 1};
  return r;
}

TEST(LightSelector, ChoosesWithItsReportedProbability) {
  constexpr std::uint32_t kLights = 22, kChoices = 1 << 16;
  const LightSelector selector = row_of_lamps(kLights - 2);
  for (const LightSelection how : kLightSelections) {
    const Receiver receiver = floor_at(3);
    std::vector<double> chosen(kLights);
    for (std::uint32_t i = 0; i < kChoices; ++i) {
      const auto choice = selector.choose(how, receiver, (i + 0.5) / kChoices);
      ASSERT_TRUE(choice);
      ASSERT_LT(choice->light, kLights);
      EXPECT_EQ(choice->probability, selector.probability(how, receiver, choice->light));
      chosen[choice->light] += 1.0 / kChoices;
    }
    double sum = 0;
    for (std::uint32_t l = 0; l < kLights; ++l) {
      const double p = selector.probability(how, receiver, l);
      sum += p;
      // Equidistant values miss an interval by one at each end.
      EXPECT_NEAR(chosen[l], p, 2.0 / kChoices) << l << " by way " << int(how);
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(LightSelector, GivesHalfToDistantLightsByTheirIlluminance) {
  const LightSelector selector = row_of_lamps(20);
  const std::uint32_t bright = 11, dim = 21;
  for (const LightSelection how : {LightSelection::kPower, LightSelection::kBvh}) {
    // 9/10 by 30 lx and 10 lx, 1/10 equally.
    EXPECT_NEAR(selector.probability(how, floor_at(0), bright), 0.5 * (0.9 * 0.75 + 0.05), 1e-15);
    EXPECT_NEAR(selector.probability(how, floor_at(0), dim), 0.5 * (0.9 * 0.25 + 0.05), 1e-15);
  }
}

TEST(LightSelector, GivesAllToTheOnlyKindOfLight) {
  std::vector<LightSelector::Item> far, near;
  far.push_back(sky(1, 1));
  far.push_back(sky(1, 1));
  near.push_back(lamp(0, 2));
  near.push_back(lamp(1, 2));
  for (auto* items : {&far, &near}) {
    const LightSelector selector(numbered(*items));
    // The tree's boxes are wider than the lights by a few roundings of floats.
    for (const LightSelection how : kLightSelections)
      EXPECT_NEAR(selector.probability(how, floor_at(0.5), 0), 0.5, 1e-8);
  }
}

TEST(LightSelector, NeverChoosesBlackDistantLights) {
  const LightSelector selector(numbered({lamp(0, 1), sky(0, 0), lamp(1, 1)}));
  for (const LightSelection how : {LightSelection::kPower, LightSelection::kBvh})
    EXPECT_EQ(selector.probability(how, floor_at(0), 1), 0);
}

TEST(LightSelector, TheTreeDependsOnTheReceiver) {
  const LightSelector selector = row_of_lamps(20);
  const auto p = [&](double x, std::uint32_t light) {
    return selector.probability(LightSelection::kBvh, floor_at(x), light);
  };
  EXPECT_GT(p(0, 0), 3 * p(19, 0));
  EXPECT_EQ(selector.probability(LightSelection::kPower, floor_at(0), 0),
            selector.probability(LightSelection::kPower, floor_at(19), 0));
}

TEST(LightSelector, BuildsNoTreeWithoutUse) {
  const LightSelector few = row_of_lamps(8), many = row_of_lamps(9);
  EXPECT_EQ(few.automatic(), LightSelection::kPower);
  EXPECT_EQ(many.automatic(), LightSelection::kBvh);
  (void)few.choose(LightSelection::kAutomatic, floor_at(0), 0.3);
  EXPECT_EQ(few.tree_part().bytes(), 0u);
  (void)few.choose(LightSelection::kBvh, floor_at(0), 0.9);
  EXPECT_GT(few.tree_part().bytes(), 0u);
}

TEST(LightSelector, DropsTheBoundsOnceTheTreeHasThem) {
  constexpr std::size_t kLights = 1 << 10;
  const LightSelector selector = row_of_lamps(kLights);
  // A number and two cumulative powers for each light, and room for twice as many numbers.
  EXPECT_LE(selector.bytes(), (kLights + 2) * (2 * 4 + 2 * 8));
}

TEST(LightSelector, ReturnsIndicesOfTheScene) {
  std::vector<LightSelector::Item> items = {lamp(0, 1), sky(1, 1), lamp(1, 3)};
  items[0].light = 4, items[1].light = 7, items[2].light = 9;
  const LightSelector selector(std::move(items));
  for (const LightSelection how : kLightSelections) {
    double sum = 0;
    for (const std::uint32_t light : {4U, 7U, 9U})
      sum += selector.probability(how, floor_at(0), light);
    EXPECT_NEAR(sum, 1, 1e-12);
    for (int i = 0; i < 64; ++i) {
      const auto choice = selector.choose(how, floor_at(0), i / 64.0);
      EXPECT_TRUE(choice->light == 4 || choice->light == 7 || choice->light == 9);
    }
  }
}

TEST(LightSelector, EmittersAreChosenByFluxAlone) {
  const LightSelector selector(numbered({lamp(0, 3), sky(1, 1e6)}));
  EXPECT_NEAR(selector.by_flux().probability(0), 0.9 * 0.75 + 0.05, 1e-15);
}

}  // namespace
}  // namespace lucerna
