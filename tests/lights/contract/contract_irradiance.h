// The contract of lights that have a closed form of their irradiance, as one typed suite.  It takes
// the cases of contract.h.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "lights/models/irradiance.h"
#include "lights/sampling/sobol.h"
#include "tests/lights/contract/contract.h"

namespace lucerna::testing {

template <typename Case>
class LightWithIrradiance : public ::testing::Test {
 public:
  /// Receivers that face the light's middle, that face aside, and whose horizon may cut the light.
  static std::vector<Receiver> receivers() {
    std::vector<Receiver> all;
    for (const Vec3& position : Case::receivers()) {
      const Vec3 to = normalized(Case::centre() - position);
      const auto frame = Frame::around(to == Vec3{} ? Vec3{0, 0, 1} : to);
      for (const Vec3& local : {Vec3{0, 0, 1},
                                {0.6, 0, 0.8},
                                {0.8, -0.6, 0.125},
                                {-0.6, 0.8, -0.0625},
                                {0, 1, -0.375},
                                {0, 0, -1}}) {
        Receiver receiver(position);
        receiver.normal = normalized(frame.world_from_local(local));
        all.push_back(receiver);
      }
    }
    return all;
  }

 protected:
  LightWithIrradiance() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("LightWithIrradiance");
};
TYPED_TEST_SUITE_P(LightWithIrradiance);

/// The mean of samples over Sobol points, in the green channel.  The standard error comes from
/// independent randomisations of the points.
template <typename Light>
std::pair<double, double> mean_of_samples(const Light& light, const Receiver& receiver,
                                          std::uint64_t item) {
  constexpr int kBlocks = 16;
  constexpr std::uint32_t kSamples = 4096;
  double sum = 0, squares = 0;
  for (int r = 0; r < kBlocks; ++r) {
    const SobolSequence sequence(7, item, static_cast<std::uint64_t>(r));
    double mean = 0;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const Vec2f u = sequence.pair(i, 0);
      const auto s = light.sample_li(receiver, {u.x, u.y});
      if (s.reason == NoLight::kNone)
        mean += s.value.g * std::fmax(0, dot(receiver.normal, s.wi)) / s.pdf.per_sr / kSamples;
    }
    sum += mean, squares += mean * mean;
  }
  const double mean = sum / kBlocks;
  const double variance = std::fmax(0, squares / kBlocks - mean * mean) / (kBlocks - 1);
  return {mean, std::sqrt(variance)};
}

TYPED_TEST_P(LightWithIrradiance, IsTheMeanOfSamples) {
  const auto light = TypeParam::make({});
  std::uint64_t item = 0;
  int lit = 0;
  for (const auto& receiver : TestFixture::receivers()) {
    const auto lx = light.irradiance(receiver);
    ASSERT_TRUE(lx);
    const auto [mean, error] = mean_of_samples(light, receiver, ++item);
    // 16 randomisations are off by more than 12 standard errors less than once in 1e8 (Student).
    EXPECT_LE(std::fabs(lx->g - mean), 12 * error + 1e-9 * mean)
        << mean << " +- " << error << " at " << item;
    EXPECT_LE(error, 0.01 * std::fmax(mean, 0.01))
        << "the test is too inaccurate to notice mistakes";
    lit += lx->g > 0;
  }
  EXPECT_GT(lit, 0);
}

TYPED_TEST_P(LightWithIrradiance, RigidMotionChangesNothing) {
  const Placement placement = moved();
  const auto light = TypeParam::make({});
  const auto elsewhere = TypeParam::make(placement);
  for (const auto& receiver : TestFixture::receivers()) {
    Receiver there(placement.point(receiver.position));
    there.normal = placement.direction(receiver.normal);
    const auto a = light.irradiance(receiver), b = elsewhere.irradiance(there);
    ASSERT_TRUE(a && b);
    EXPECT_LE(std::fabs(a->g - b->g), 1e-12 * std::fmax(1, a->g));
  }
}

TYPED_TEST_P(LightWithIrradiance, ScalingByPowersOfTwoChangesNoBit) {
  const auto light = TypeParam::make({});
  for (const int k : {-20, -1, 3, 20}) {
    const Placement placement{{}, k};
    const auto scaled_light = TypeParam::make(placement);
    for (const auto& receiver : TestFixture::receivers()) {
      Receiver there(placement.point(receiver.position));
      there.normal = receiver.normal;
      EXPECT_EQ(light.irradiance(receiver), scaled_light.irradiance(there));
    }
  }
}

TYPED_TEST_P(LightWithIrradiance, HasNoResultForInvalidReceivers) {
  const auto light = TypeParam::make({});
  Receiver receiver(TypeParam::receivers().front());
  EXPECT_FALSE(light.irradiance(receiver)) << "without a normal all directions count alike";
  receiver.normal = {0, 0, 1};
  EXPECT_TRUE(light.irradiance(receiver));
  for (const double bad : {std::nan(""), double{INFINITY}}) {
    Receiver nowhere = receiver, no_way = receiver;
    nowhere.position.y = bad, no_way.normal.x = bad;
    EXPECT_FALSE(light.irradiance(nowhere));
    EXPECT_FALSE(light.irradiance(no_way));
  }
}

REGISTER_TYPED_TEST_SUITE_P(LightWithIrradiance, IsTheMeanOfSamples, RigidMotionChangesNothing,
                            ScalingByPowersOfTwoChangesNoBit, HasNoResultForInvalidReceivers);

}  // namespace lucerna::testing
