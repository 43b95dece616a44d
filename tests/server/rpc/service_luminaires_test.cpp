// Luminaires as people have them, from the file to the answers.  The fluxes are integrals of the
// files' grids with 50 digits, by the antiderivatives in tests/data/extremes/photometric.py.
#include <gmock/gmock.h>

#include <cmath>

#include "service_fixture.h"

namespace lucerna::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

rpc::ServerOptions luminaires() { return scenes_in(test_data("luminaires")); }

class LuminaireService : public ::testing::Test {
 protected:
  /// "what -> instead" of each remark.
  std::vector<std::string> load(const std::string& path) {
    v1::LoadSceneRequest request;
    request.set_path(path);
    const auto response = service_.answer(request);
    scene_ = response.scene_id();
    std::vector<std::string> remarks;
    for (const v1::Remark& remark : response.remarks())
      remarks.push_back(remark.what() + " -> " + remark.instead());
    return remarks;
  }
  v1::EstimatePowerResponse power() {
    return service_.answer(about<v1::EstimatePowerRequest>(scene_));
  }
  double lumens(const std::string& path) {
    load(path);
    return power().total().power_lm();
  }
  double lux(const Vec3& point, const Vec3& normal) {
    auto request = about<v1::EstimateIrradianceRequest>(scene_);
    set(request.mutable_receivers()->mutable_offsets_m(), point.x, point.y, point.z);
    set(request.mutable_normals(), normal.x, normal.y, normal.z);
    request.set_bounces(0);
    const auto response = service_.answer(request);
    return response.illuminance_lx_size() == 1 ? response.illuminance_lx(0) : -1;
  }

  Service service_{luminaires()};
  std::string scene_;
};

// 100 cos H cd for every V.  At H = V = 45 degrees that is 70.71 cd, towards (1/2, sqrt(1/2), 1/2).
TEST_F(LuminaireService, TypeBHasItsPoleAtH90) {
  EXPECT_NEAR(lumens("typeb_tube.pbrt"), 493.167155, 1e-5);
  EXPECT_NEAR(lux({0.5, 0.70710678, 0.5}, {-0.5, -0.70710678, -0.5}), 70.7107, 1e-4);
  EXPECT_NEAR(lux({0, 1, 0}, {0, -1, 0}), 0, 1e-4);
  EXPECT_NEAR(lux({0.70710678, 0, 0.70710678}, {-1, 0, -1}), 100, 1e-4);
  EXPECT_NEAR(lumens("typeb_tube.gltf"), 493.167155, 1e-5);
  // The node's -z is V = H = 0, and the pole is its y.
  EXPECT_NEAR(lux({0.5, -0.70710678, -0.5}, {-0.5, 0.70710678, 0.5}), 70.7107, 1e-4);
  EXPECT_NEAR(lux({0, -1, 0}, {0, 1, 0}), 0, 1e-4);
  EXPECT_NEAR(lux({0.70710678, 0, -0.70710678}, {-1, 0, 1}), 100, 1e-4);
}

// 20 mW/sr over a half: 40 pi mW.
TEST_F(LuminaireService, RadiantIntensitiesAreNotCalledLumens) {
  const auto remarks = load("radiant.pbrt");
  EXPECT_THAT(remarks,
              ElementsAre("radiant.ies:3: intensities in mW/sr, not in cd -> read as if in cd: of "
                          "this light, lm stand for mW and lx for mW/m2",
                          HasSubstr("a luminous opening of 0.06 x 0.06 m")));
  v1::EstimatePowerResponse answer = power();
  EXPECT_NEAR(answer.lights(0).power_lm(), 40 * kPi, 1e-9);
  EXPECT_EQ(answer.lights(0).power_unit(), "mW");
  EXPECT_EQ(answer.total().power_unit(), "mW");
  // With "power" the flux of a light is in lm, whatever the file's unit.
  load("radiant_and_lamp.pbrt");
  answer = power();
  EXPECT_EQ(answer.lights(0).power_unit(), "mW");
  EXPECT_EQ(answer.lights(1).power_unit(), "");
  EXPECT_NEAR(answer.lights(1).power_lm(), 100, 1e-9);
  EXPECT_EQ(answer.total().power_unit(), "mixed");
  const auto lights = service_.answer(about<v1::ListLightsRequest>(scene_));
  EXPECT_EQ(lights.lights(0).power_unit(), "mW");
  EXPECT_EQ(lights.lights(1).power_unit(), "");
  for (const v1::Light& light : lights.lights())
    EXPECT_EQ(light.goniometric().photometric_file().flux_unit(), "mW");
}

}  // namespace
}  // namespace lucerna::testing
