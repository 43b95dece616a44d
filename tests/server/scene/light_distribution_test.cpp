#include "server/scene/light_distribution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lucerna {
namespace {

TEST(LightDistribution, GivesNineTenthsByPowerAndOneTenthEqually) {
  const LightDistribution d(std::vector<double>{1, 3});
  EXPECT_NEAR(d.probability(0), 0.9 * 0.25 + 0.05, 1e-15);
  EXPECT_NEAR(d.probability(1), 0.9 * 0.75 + 0.05, 1e-15);
  EXPECT_EQ(d.choose(0.2749).light, 0u);
  EXPECT_EQ(d.choose(0.2751).light, 1u);
  EXPECT_EQ(d.choose(0.2751).probability, d.probability(1));
}

TEST(LightDistribution, NeverChoosesALightWithoutPower) {
  const LightDistribution d(std::vector<double>{0, 2, 0, 0, 5, 0});
  for (const std::uint32_t black : {0u, 2u, 3u, 5u}) EXPECT_EQ(d.probability(black), 0);
  EXPECT_EQ(d.choose(0).light, 1u);
  EXPECT_EQ(d.choose(1 - 0x1p-53).light, 4u);
  EXPECT_EQ(d.probability(1) + d.probability(4), 1);
}

TEST(LightDistribution, IsUniformWhereAllLightsAreBlack) {
  const LightDistribution d(std::vector<double>{0, 0, 0, 0});
  for (std::uint32_t l = 0; l < 4; ++l) EXPECT_EQ(d.probability(l), 0.25);
  EXPECT_EQ(d.choose(0.6).light, 2u);
}

TEST(LightDistribution, ReachesEveryLightBesideOneOfOverwhelmingPower) {
  // A distant light's flux in a scene of 1e6 m, and lamps.
  std::vector<double> lumens(100'000, 1);
  lumens[777] = 1e300;
  const LightDistribution d(lumens);
  double u = 0, sum = 0;
  for (std::uint32_t l = 0; l < lumens.size(); ++l) {
    EXPECT_GE(d.probability(l), 0.999 * 0.1 / 1e5);
    ASSERT_EQ(d.choose(u + d.probability(l) / 2).light, l);
    u += d.probability(l);
    sum += d.probability(l);
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(LightDistribution, DoesNotChangeWhenAllPowersDouble) {
  const std::vector<double> lumens{0.3, 7, 1e-9, 42};
  std::vector<double> doubled = lumens;
  for (double& l : doubled) l *= 0x1p40;
  const LightDistribution a(lumens), b(doubled);
  for (std::uint32_t l = 0; l < 4; ++l) EXPECT_EQ(a.probability(l), b.probability(l));
}

}  // namespace
}  // namespace lucerna
