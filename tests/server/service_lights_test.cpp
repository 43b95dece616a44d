// What ListLights tells of each kind of light: the scene file's words, on the wire.
#include <numbers>

#include "service_fixture.h"
#include "tests/server/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

constexpr double kPi = std::numbers::pi;

/// The lights of a scene of one file, and a picture beside it: slide.pfm, 4 x 2 texels of 1.
std::vector<v1::Light> lights_of(const std::string& text) {
  const SceneFiles files;
  files.write("scene.pbrt", "WorldBegin\n" + text);
  const float one = 1;
  std::string picture = "PF\n4 2\n-1.0\n";
  for (int i = 0; i < 4 * 2 * 3; ++i)
    picture.append(reinterpret_cast<const char*>(&one), sizeof one);
  files.write("slide.pfm", picture);
  rpc::ServerOptions options = service_options();
  options.scene_root = files.path().string();
  Service service(options);
  v1::ListLightsRequest request;
  request.set_scene_id(service.load("scene.pbrt"));
  v1::ListLightsResponse response;
  const grpc::Status status =
      ask([&](auto* c) { return service.scenes.ListLights(c, request, &response); });
  EXPECT_TRUE(status.ok()) << status.error_message();
  return {response.lights().begin(), response.lights().end()};
}

void expect(const v1::Vector3& v, double x, double y, double z, double tolerance = 1e-12) {
  EXPECT_NEAR(v.x(), x, tolerance);
  EXPECT_NEAR(v.y(), y, tolerance);
  EXPECT_NEAR(v.z(), z, tolerance);
}

void expect(const v1::Rgb& c, double r, double g, double b) {
  EXPECT_NEAR(c.r(), r, 1e-12 * r);
  EXPECT_NEAR(c.g(), g, 1e-12 * g);
  EXPECT_NEAR(c.b(), b, 1e-12 * b);
}

TEST(ListLights, SpotTellsItsProfile) {
  const std::string spot =
      "LightSource \"spot\" \"float coneangle\" 60 \"float conedeltaangle\" 60 ";
  const auto lights = lights_of(spot + "\"string profile\" \"quartic\"\n" + spot);
  ASSERT_EQ(lights.size(), 2U);
  EXPECT_EQ(lights[0].spot().profile(), v1::SPOT_PROFILE_QUARTIC);
  EXPECT_EQ(lights[1].spot().profile(), v1::SPOT_PROFILE_SMOOTHSTEP);
  for (const v1::Light& light : lights) {
    EXPECT_NEAR(light.spot().cone_half_angle_rad(), kPi / 3, 1e-12);
    EXPECT_NEAR(light.spot().falloff_start_rad(), 0, 1e-12);
    EXPECT_TRUE(light.delta());
  }
  // All edge: 2 pi (1 - 1/2) times the mean of x^4 and of smoothstep.
  EXPECT_NEAR(lights[0].power_lm(), kPi / 5, 1e-12);
  EXPECT_NEAR(lights[1].power_lm(), kPi / 2, 1e-12);
}

TEST(ListLights, ADistantLightOfAnAngularDiameterIsASun) {
  const std::string distant =
      "LightSource \"distant\" \"point3 from\" [0 3 4] \"point3 to\" [0 0 0] \"rgb L\" [1 2 3] ";
  const auto lights = lights_of(distant + "\"float angulardiameter\" 0.53\n" + distant);
  ASSERT_EQ(lights.size(), 2U);
  ASSERT_EQ(lights[0].kind_case(), v1::Light::kSun);
  EXPECT_EQ(lights[1].kind_case(), v1::Light::kDistant);
  EXPECT_NEAR(lights[0].sun().angular_diameter_rad(), 0.53 * kPi / 180, 1e-15);
  expect(lights[0].sun().to_light(), 0, 3, 4);
  expect(lights[0].sun().illuminance_lx(), 1, 2, 3);
  EXPECT_FALSE(lights[0].delta());
  EXPECT_FALSE(lights[0].has_bounds());
}

TEST(ListLights, ProjectionTellsItsAxesAndItsPicture) {
  const auto lights = lights_of(
      "Translate 1 2 3 Rotate 90 1 0 0 Scale 2 2 2\n"
      "LightSource \"projection\" \"string filename\" \"slide.pfm\" \"float fov\" 30 \"float "
      "scale\" 7 \"string filter\" \"bilinear\"\n"
      "LightSource \"projection\" \"float fov\" 30");
  ASSERT_EQ(lights.size(), 2U);
  const v1::ProjectionLight& p = lights[0].projection();
  expect(p.position_m(), 1, 2, 3);
  expect(p.axis(), 0, -1, 0);  // +z turned about +x
  expect(p.right(), 1, 0, 0);
  expect(p.up(), 0, 0, 1);
  EXPECT_NEAR(p.fov_rad(), kPi / 6, 1e-12);
  EXPECT_DOUBLE_EQ(p.aspect(), 2);
  expect(p.intensity_cd(), 7, 7, 7);
  EXPECT_EQ(p.image().name(), "slide.pfm");
  EXPECT_EQ(p.image().width(), 4U);
  EXPECT_EQ(p.image().height(), 2U);
  EXPECT_EQ(p.image().filter(), v1::IMAGE_FILTER_BILINEAR);
  EXPECT_TRUE(lights[0].delta());
  EXPECT_FALSE(lights[0].has_area_m2());
  expect(lights[0].bounds().lower_m(), 1, 2, 3);
  expect(lights[0].bounds().upper_m(), 1, 2, 3);
  EXPECT_FALSE(lights[1].projection().has_image());
  EXPECT_DOUBLE_EQ(lights[1].projection().aspect(), 1);
  // White pictures: a pyramid of half apex angles 15 degrees, and one twice as wide (tangent).
  const double sin = std::sin(kPi / 12), wide = 2 * std::tan(kPi / 12);
  EXPECT_NEAR(lights[1].power_lm(), 4 * std::asin(sin * sin), 1e-12);
  EXPECT_EQ(lights[1].power_error_lm(), 0);
  EXPECT_NEAR(lights[0].power_lm(), 7 * 4 * std::asin(sin * wide / std::hypot(1, wide)), 1e-12);
  EXPECT_NEAR(lights[0].power_error_lm(), 1e-14 * lights[0].power_lm(), 1e-20);
}

TEST(ListLights, BeamTellsItsRectangle) {
  const auto lights = lights_of(
      "Translate 1 2 3\n"
      "LightSource \"projection\" \"string projection\" \"orthographic\" \"string filename\" "
      "\"slide.pfm\" \"float extent\" 0.5 \"float scale\" 200");
  ASSERT_EQ(lights.size(), 1U);
  const v1::BeamLight& b = lights[0].beam();
  expect(b.position_m(), 1, 2, 3);
  expect(b.axis(), 0, 0, 1);
  expect(b.right(), 1, 0, 0);
  expect(b.up(), 0, 1, 0);
  EXPECT_DOUBLE_EQ(b.width_m(), 1);
  EXPECT_DOUBLE_EQ(b.height_m(), 0.5);
  expect(b.illuminance_lx(), 200, 200, 200);
  EXPECT_EQ(b.image().filter(), v1::IMAGE_FILTER_NEAREST);
  EXPECT_TRUE(lights[0].delta());
  // A float's rounding wider.
  const v1::Bounds& bounds = lights[0].bounds();
  expect(bounds.lower_m(), 0.5, 1.75, 3, 1e-6);
  expect(bounds.upper_m(), 1.5, 2.25, 3, 1e-6);
  expect(lights[0].directions().axis(), 0, 0, 1);
  EXPECT_LT(lights[0].directions().half_angle_rad(), 1e-6);
  EXPECT_NEAR(lights[0].power_lm(), 100, 1e-9);
  EXPECT_EQ(lights[0].power_error_lm(), 0);
}

}  // namespace
}  // namespace lucerna::testing
