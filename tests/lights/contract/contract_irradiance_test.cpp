// The contract of irradiance in closed form on flat lights.
#include "tests/lights/contract/contract_irradiance.h"

#include <gtest/gtest.h>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"

namespace lucerna::testing {
namespace {

constexpr Rgb kLevel{1, 2, 4};

/// A trapezoid that emits on both sides.
struct TrapezoidCase : CaseDefaults {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    const auto p = [&](double x, double y) { return at.point({x, y, 0}); };
    return *Light::create({kLevel, true},
                          *PatchMesh::create({{p(-1, -1), p(1, -1), p(-0.5, 1), p(0.5, 1)}}));
  }
  static std::vector<Vec3> receivers() {
    return {{0.5, 0.25, 3}, {0.5, -1, -2.5}, {1.5, 0.25, 0.125}, {0.25, 0.125, 0.0625}};
  }
};

struct WholeDiskCase : CaseDefaults {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *Light::create(
        {kLevel}, *Disk::create({.radius_m = 1.5, .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() {
    return {{0, 0.5, 2}, {2, -1, 1.5}, {0, 0, 0.5}, {1.625, 0, 0.25}};
  }
};

using FlatCases = ::testing::Types<TrapezoidCase, WholeDiskCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Flat, LightWithIrradiance, FlatCases);

TEST(LightWithIrradiance, IsZeroBehindOneSidedLights) {
  Receiver receiver(0.25, 0.5, -2);
  receiver.normal = {0, 0, 1};
  EXPECT_EQ(WholeDiskCase::make({}).irradiance(receiver)->g, 0);
  EXPECT_GT(TrapezoidCase::make({}).irradiance(receiver)->g, 0);
  receiver.normal = {0, 0, -1};
  EXPECT_EQ(TrapezoidCase::make({}).irradiance(receiver)->g, 0);
}

TEST(LightWithIrradiance, ChangesSidesAtTheSurfaceOfSpheres) {
  for (const bool inwards : {false, true})
    for (const bool two_sided : {false, true}) {
      const auto light = *AreaLight::create({kLevel, two_sided},
                                            *Sphere::create({.reverse_orientation = inwards}));
      Receiver inside(0.5, 0.25, 0), outside(0, 0, 2), on(0, 0, 1);
      inside.normal = outside.normal = on.normal = {0, 0, -1};
      EXPECT_EQ(light.irradiance(inside)->g,
                inwards || two_sided ? kLevel.g * std::numbers::pi : 0);
      EXPECT_EQ(light.irradiance(outside)->g,
                !inwards || two_sided ? kLevel.g * std::numbers::pi / 4 : 0);
      EXPECT_FALSE(light.irradiance(on));
    }
}

}  // namespace
}  // namespace lucerna::testing
