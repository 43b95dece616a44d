// LoadSceneRequest.blender: the light levels of glTF files from Blender.
#include <cmath>
#include <limits>
#include <numbers>

#include "service_fixture.h"
#include "tests/paths.h"

namespace lucerna::testing {
namespace {

class BlenderServiceTest : public ::testing::Test {
 protected:
  /// The scenes in tests/data/gltf.
  static rpc::ServerOptions options() { return scenes_in(test_data("gltf")); }

  grpc::Status load(const v1::LoadSceneRequest& request) {
    return service_.call(request, &loaded_);
  }
  std::string id(const v1::LoadSceneRequest& request) {
    const grpc::Status status = load(request);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return loaded_.scene_id();
  }
  v1::SceneSummary summary(const std::string& id) {
    const auto scene = service_.answer(about<v1::GetSceneRequest>(id));
    return scene.summary();
  }
  static v1::LoadSceneRequest request(v1::BlenderLightingMode mode) {
    v1::LoadSceneRequest request;
    request.set_path("room.gltf");
    request.mutable_blender()->set_mode(mode);
    return request;
  }

  Service service_{options()};
  v1::LoadSceneResponse loaded_;
};

TEST_F(BlenderServiceTest, FactorsMakeAnotherSceneThatReportsThem) {
  const std::string plain = service_.load("room.gltf");
  v1::LoadSceneRequest standard = request(v1::BLENDER_LIGHTING_MODE_STANDARD);
  const std::string bright = id(standard);
  EXPECT_NE(bright, plain);
  standard.mutable_blender()->set_lumens_per_watt(683);  // the default
  EXPECT_EQ(id(standard), bright);
  EXPECT_TRUE(loaded_.already_loaded());
  standard.mutable_blender()->set_lumens_per_watt(100);
  const std::string electric = id(standard);
  EXPECT_NE(electric, bright);
  EXPECT_EQ(service_.load("room.gltf"), plain);
  EXPECT_EQ(service_.server->scenes().builds(), 3U);

  EXPECT_FALSE(summary(plain).has_level_factors());
  EXPECT_EQ(summary(bright).level_factors().lamps(), 1);
  EXPECT_EQ(summary(bright).level_factors().suns(), 1);
  EXPECT_EQ(summary(bright).level_factors().emission(), 683);
  EXPECT_EQ(summary(electric).level_factors().lamps(), 100.0 / 683);
  EXPECT_EQ(summary(electric).level_factors().suns(), 100.0 / 683);
  EXPECT_EQ(summary(electric).level_factors().emission(), 100);
}

TEST_F(BlenderServiceTest, EachModeHasItsFactors) {
  const auto unitless = summary(id(request(v1::BLENDER_LIGHTING_MODE_UNITLESS))).level_factors();
  EXPECT_EQ(unitless.lamps(), 683);
  EXPECT_EQ(unitless.suns(), 683);
  EXPECT_EQ(unitless.emission(), 683);
  const auto raw = summary(id(request(v1::BLENDER_LIGHTING_MODE_RAW))).level_factors();
  EXPECT_EQ(raw.lamps(), 683 / (4 * std::numbers::pi));
  EXPECT_EQ(raw.suns(), 683);
  EXPECT_EQ(raw.emission(), 683);
}

TEST_F(BlenderServiceTest, LightsHaveTheLevels) {
  const auto lights = service_.answer(
      about<v1::ListLightsRequest>(id(request(v1::BLENDER_LIGHTING_MODE_STANDARD))));
  ASSERT_EQ(lights.lights_size(), 4);
  EXPECT_EQ(lights.lights(0).point().intensity_cd().r(), 40);
  EXPECT_EQ(lights.lights(3).name(), "panel");
  EXPECT_EQ(lights.lights(3).diffuse_area().radiance_cd_m2().r(), 683 * 800);
}

TEST_F(BlenderServiceTest, WrongValuesNameTheirField) {
  expect_bad_field(load(request(v1::BLENDER_LIGHTING_MODE_UNSPECIFIED)), "blender.mode");
  expect_bad_field(load(request(static_cast<v1::BlenderLightingMode>(4))), "blender.mode");
  v1::LoadSceneRequest wrong = request(v1::BLENDER_LIGHTING_MODE_RAW);
  for (const double value :
       {0.0, -1.0, 1.0000001e6, std::nan(""), std::numeric_limits<double>::infinity()}) {
    wrong.mutable_blender()->set_lumens_per_watt(value);
    expect_bad_field(load(wrong), "blender.lumens_per_watt");
  }
  wrong.mutable_blender()->set_lumens_per_watt(1e6);
  EXPECT_TRUE(load(wrong).ok());
}

TEST_F(BlenderServiceTest, ScenesOfPbrtAreRefused) {
  v1::LoadSceneRequest pbrt = request(v1::BLENDER_LIGHTING_MODE_STANDARD);
  for (const char* name : {"room.pbrt", "room.pbrt.gz", "glb", "room.glb.pbrt"}) {
    pbrt.set_path(name);
    const grpc::Status status = load(pbrt);
    expect_bad_field(status, "blender");
    EXPECT_EQ(status.error_message(), "blender = BLENDER_LIGHTING_MODE_STANDARD for \"" +
                                          std::string(name) +
                                          "\", allowed: only for .gltf and .glb files");
  }
  v1::NamedAsset* asset = pbrt.mutable_manifest()->add_assets();
  asset->set_name("room.pbrt");
  asset->set_sha256(std::string(32, 'x'));
  pbrt.mutable_manifest()->set_main("room.pbrt");
  expect_bad_field(load(pbrt), "blender");
}

}  // namespace
}  // namespace lucerna::testing
