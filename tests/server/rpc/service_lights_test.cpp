// ListLights for each kind of light: the message holds the parameters of the scene file.
#include <numbers>

#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

/// The lights of a scene of one file.  Beside it are a picture, slide.pfm, with 4 x 2 texels of 1,
/// and a luminaire, lamp.ies.
std::vector<v1::Light> lights_of(const std::string& text) {
  const SceneFiles files;
  files.write("scene.pbrt", "WorldBegin\n" + text);
  const float one = 1;
  std::string picture = "PF\n4 2\n-1.0\n";
  for (int i = 0; i < 4 * 2 * 3; ++i)
    picture.append(reinterpret_cast<const char*>(&one), sizeof one);
  files.write("slide.pfm", picture);
  files.write("lamp.ies",
              "IESNA:LM-63-1995\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n");
  Service service(scenes_in(files.path()));
  const auto response = service.answer(about<v1::ListLightsRequest>(service.load("scene.pbrt")));
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

TEST(ListLights, SpotReportsItsProfile) {
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
  // All of the cone is edge: 2 pi (1 - 1/2) times the mean of x^4 and of smoothstep.
  EXPECT_NEAR(lights[0].power_lm(), kPi / 5, 1e-12);
  EXPECT_NEAR(lights[1].power_lm(), kPi / 2, 1e-12);
}

TEST(ListLights, ADistantLightWithAnAngularDiameterIsASun) {
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

TEST(ListLights, ProjectionReportsItsAxesAndItsPicture) {
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

TEST(ListLights, BeamReportsItsRectangle) {
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
  // Wider by a float's rounding.
  const v1::Bounds& bounds = lights[0].bounds();
  expect(bounds.lower_m(), 0.5, 1.75, 3, 1e-6);
  expect(bounds.upper_m(), 1.5, 2.25, 3, 1e-6);
  expect(lights[0].directions().axis(), 0, 0, 1);
  EXPECT_LT(lights[0].directions().half_angle_rad(), 1e-6);
  EXPECT_NEAR(lights[0].power_lm(), 100, 1e-9);
  EXPECT_EQ(lights[0].power_error_lm(), 0);
}

const v1::RoundShape& round_of(const v1::Light& light) { return light.diffuse_area().round(); }

TEST(ListLights, SpheresReportTheirRemainingPart) {
  const std::string emits = "AreaLightSource \"diffuse\" ";
  const auto lights =
      lights_of("Translate 1 2 3 Rotate 90 0 1 0 Scale 2 2 2\n" + emits +
                "Shape \"sphere\" \"float radius\" 0.5\n"
                "ReverseOrientation Shape \"sphere\" \"float radius\" 0.5 \"float zmin\" -0.25 "
                "\"float zmax\" 9 \"float phimax\" 90");
  ASSERT_EQ(lights.size(), 2U);
  for (const v1::Light& light : lights) {
    const v1::RoundShape& round = round_of(light);
    expect(round.center_m(), 1, 2, 3);
    // Turned about +y: +z to +x, +x to -z.
    expect(round.axes().x(), 0, 0, -1);
    expect(round.axes().y(), 0, 1, 0);
    expect(round.axes().z(), 1, 0, 0);
    EXPECT_DOUBLE_EQ(round.radius_m(), 1);
    EXPECT_DOUBLE_EQ(round.z_max_m(), 1);
    EXPECT_FALSE(round.has_radius_y_m());
    EXPECT_EQ(round.inner_radius_m(), 0);
  }
  EXPECT_DOUBLE_EQ(round_of(lights[0]).z_min_m(), -1);
  EXPECT_DOUBLE_EQ(round_of(lights[0]).phi_max_rad(), 2 * kPi);
  EXPECT_FALSE(round_of(lights[0]).reverse_orientation());
  EXPECT_DOUBLE_EQ(round_of(lights[1]).z_min_m(), -0.5);
  EXPECT_DOUBLE_EQ(round_of(lights[1]).phi_max_rad(), kPi / 2);
  EXPECT_TRUE(round_of(lights[1]).reverse_orientation());
}

TEST(ListLights, DisksMayBeRingsAndEllipses) {
  const std::string ring =
      "AreaLightSource \"diffuse\" Shape \"disk\" \"float height\" 1 \"float radius\" 0.5 "
      "\"float innerradius\" 0.125 \"float phimax\" 180\n";
  const auto lights = lights_of("Translate 0 0 2 Scale 2 2 3\n" + ring + "Scale 1 3 1\n" + ring);
  ASSERT_EQ(lights.size(), 2U);
  for (const v1::Light& light : lights) {
    const v1::RoundShape& round = round_of(light);
    expect(round.center_m(), 0, 0, 5);
    expect(round.axes().z(), 0, 0, 1);
    EXPECT_DOUBLE_EQ(round.radius_m(), 1);
    EXPECT_DOUBLE_EQ(round.inner_radius_m(), 0.25);
    EXPECT_DOUBLE_EQ(round.phi_max_rad(), kPi);
  }
  EXPECT_FALSE(round_of(lights[0]).has_radius_y_m());
  EXPECT_DOUBLE_EQ(round_of(lights[1]).radius_y_m(), 3);
  // Half of the area between both ellipses.
  EXPECT_NEAR(lights[1].area_m2(), kPi / 2 * (1 * 3 - 0.25 * 0.75), 1e-9);
}

TEST(ListLights, CylindersReportTheirEnds) {
  const auto lights = lights_of(
      "Translate 1 0 0 Scale 2 2 5 AreaLightSource \"diffuse\"\n"
      "Shape \"cylinder\" \"float radius\" 0.25 \"float zmin\" 0.5 \"float zmax\" -1");
  ASSERT_EQ(lights.size(), 1U);
  const v1::RoundShape& round = round_of(lights[0]);
  expect(round.center_m(), 1, 0, 0);
  EXPECT_DOUBLE_EQ(round.radius_m(), 0.5);
  EXPECT_DOUBLE_EQ(round.z_min_m(), -5);
  EXPECT_DOUBLE_EQ(round.z_max_m(), 2.5);
  EXPECT_NEAR(lights[0].area_m2(), kPi * 7.5, 1e-9);
}

TEST(ListLights, MovingLightsAreReportedAtTheirFirstKeyFrame) {
  const auto lights = lights_of(
      "ActiveTransform EndTime Translate 8 0 0\nActiveTransform All\n"
      "Translate 0 1 2 AreaLightSource \"diffuse\" Shape \"sphere\"\n"
      "Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 2 0  1 2 0]");
  ASSERT_EQ(lights.size(), 2U);
  EXPECT_TRUE(lights[0].has_motion());
  expect(round_of(lights[0]).center_m(), 0, 1, 2);
  ASSERT_EQ(lights[1].diffuse_area().corners_m_size(), 4);
  expect(lights[1].diffuse_area().corners_m(0), 0, 1, 2, 1e-6);
  expect(lights[1].diffuse_area().corners_m(3), 1, 3, 2, 1e-6);
}

TEST(ListLights, SinglePrimitivesReportTheirCorners) {
  const auto lights = lights_of(
      "Translate 100 0 3 AreaLightSource \"diffuse\"\n"
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 2 0] \"integer indices\" [0 1 2]\n"
      "ReverseOrientation\n"
      "Shape \"bilinearmesh\" \"point3 P\" [0 0 0  1 0 0  0 2 0  1 2 0]\n"
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 2 0  1 2 0] "
      "\"integer indices\" [0 1 2  1 3 2]");
  ASSERT_EQ(lights.size(), 3U);
  for (int i = 0; i < 2; ++i) {
    const v1::DiffuseAreaLight& area = lights[i].diffuse_area();
    ASSERT_EQ(area.corners_m_size(), 3 + i);
    expect(area.corners_m(0), 100, 0, 3, 1e-5);
    // The emitting side is that of the corners' cross product, up and down.
    const double up = (area.corners_m(1).x() - 100) * area.corners_m(2).y() -
                      area.corners_m(1).y() * (area.corners_m(2).x() - 100);
    EXPECT_NEAR(up, i == 0 ? 2 : -2, 1e-4);
    EXPECT_NEAR(lights[i].directions().axis().z(), i == 0 ? 1 : -1, 1e-6);
    EXPECT_FALSE(area.has_round());
  }
  EXPECT_EQ(lights[2].diffuse_area().corners_m_size(), 0);
}

TEST(ListLights, PhotometryAndPicturesReportTheirRotation) {
  const std::string turned = "Rotate 90 0 0 1 ";  // +x to +y, +y to -x
  const auto lights = lights_of(
      "AttributeBegin " + turned +
      "LightSource \"goniometric\" \"string filename\" \"lamp.ies\"\n"
      "LightSource \"goniometric\" \"rgb I\" [1 1 1]\n"
      "LightSource \"infinite\" \"string filename\" \"slide.pfm\" \"string mapping\" \"latlong\"\n"
      "LightSource \"infinite\" \"string filename\" \"slide.pfm\" \"string mapping\" \"latlong\" "
      "\"point3 portal\" [0 0 3  0 1 3  2 1 3  2 0 3]\n"
      "LightSource \"goniometric\" \"string filename\" \"slide.pfm\" \"string mapping\" "
      "\"latlong\"\n"
      "AreaLightSource \"diffuse\" \"string profile\" \"lamp.ies\" Shape \"disk\" AttributeEnd\n"
      "Scale -3 3 3 LightSource \"goniometric\" \"string filename\" \"lamp.ies\"\n"
      "LightSource \"infinite\" \"string filename\" \"slide.pfm\" \"string mapping\" "
      "\"latlong\"\n");
  ASSERT_EQ(lights.size(), 8U);
  const auto expect_turned = [](const v1::Axes& axes) {
    expect(axes.x(), 0, 1, 0);
    expect(axes.y(), -1, 0, 0);
    expect(axes.z(), 0, 0, 1);
  };
  const auto expect_mirrored = [](const v1::Axes& axes) {
    expect(axes.x(), -1, 0, 0);
    expect(axes.y(), 0, 1, 0);
    expect(axes.z(), 0, 0, 1);
  };
  std::vector<const v1::Light*> by_kind[3];
  for (const v1::Light& light : lights) {
    if (light.has_goniometric()) by_kind[0].push_back(&light);
    if (light.has_image_infinite()) by_kind[1].push_back(&light);
    if (light.has_diffuse_area()) by_kind[2].push_back(&light);
  }
  ASSERT_EQ(by_kind[0].size(), 4U);
  ASSERT_EQ(by_kind[1].size(), 3U);
  ASSERT_EQ(by_kind[2].size(), 1U);
  expect_turned(by_kind[0][0]->goniometric().axes());
  EXPECT_FALSE(by_kind[0][1]->goniometric().has_axes());
  expect_turned(by_kind[0][2]->goniometric().axes());
  expect_mirrored(by_kind[0][3]->goniometric().axes());
  expect_turned(by_kind[1][0]->image_infinite().axes());
  expect_turned(by_kind[1][1]->image_infinite().axes());
  expect_mirrored(by_kind[1][2]->image_infinite().axes());
  expect_turned(by_kind[2][0]->diffuse_area().profile_axes());
}

}  // namespace
}  // namespace lucerna::testing
