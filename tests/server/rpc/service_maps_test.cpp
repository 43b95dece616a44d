// ListLights for infinite lights with a picture, a portal, or both.
#include "service_fixture.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

/// A .pfm file with 2 everywhere.
std::string sky_pfm(int width, int height) {
  std::string bytes = "PF\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
  const float v = 2;
  for (int i = 0; i < 3 * width * height; ++i)
    bytes.append(reinterpret_cast<const char*>(&v), sizeof v);
  return bytes;
}

/// The only light of a scene with a sky of 4 x 4 and one of 8 x 2 texels.
v1::Light light_of(const std::string& parameters) {
  const SceneFiles files;
  files.write("square.pfm", sky_pfm(4, 4));
  files.write("wide.pfm", sky_pfm(8, 2));
  files.write("scene.pbrt", "WorldBegin LightSource \"infinite\" " + parameters +
                                " Shape \"sphere\" \"float radius\" 1");
  Service service(scenes_in(files.path()));
  const auto response = service.answer(about<v1::ListLightsRequest>(service.load("scene.pbrt")));
  EXPECT_EQ(response.lights_size(), 1);
  return response.lights_size() == 1 ? response.lights(0) : v1::Light();
}

const std::string kPortal = "\"point3 portal\" [0 0 3  0 1 3  2 1 3  2 0 3] ";

TEST(ImageInfiniteOnTheWire, APictureWithItsMappingAndFilter) {
  const v1::Light light = light_of("\"string filename\" \"square.pfm\" \"float scale\" 3");
  ASSERT_EQ(light.kind_case(), v1::Light::kImageInfinite);
  const v1::SphereImage& map = light.image_infinite().map();
  EXPECT_EQ(map.image().name(), "square.pfm");
  EXPECT_EQ(map.image().width(), 4U);
  EXPECT_EQ(map.image().height(), 4U);
  EXPECT_EQ(map.image().filter(), v1::IMAGE_FILTER_NEAREST);
  EXPECT_EQ(map.mapping(), v1::SPHERE_MAPPING_EQUAL_AREA);
  EXPECT_EQ(light.image_infinite().radiance_cd_m2().g(), 3);
  EXPECT_EQ(light.image_infinite().portal_m_size(), 0);
  EXPECT_FALSE(light.delta());
  EXPECT_FALSE(light.has_area_m2());
  EXPECT_FALSE(light.has_bounds());
  // 6 cd/m2 from 4 pi sr through the disk of the scene's sphere, that of a box of side 2.
  EXPECT_NEAR(light.power_lm() / (6 * 4 * kPi * kPi * 3), 1, 1e-6);
  EXPECT_EQ(light.power_error_lm(), 0);
}

TEST(ImageInfiniteOnTheWire, LatitudeLongitudeAndBilinear) {
  const v1::Light light = light_of(
      "\"string filename\" \"wide.pfm\" \"string mapping\" \"latlong\" \"string filter\" "
      "\"bilinear\"");
  const v1::SphereImage& map = light.image_infinite().map();
  EXPECT_EQ(map.image().name(), "wide.pfm");
  EXPECT_EQ(map.image().width(), 8U);
  EXPECT_EQ(map.image().height(), 2U);
  EXPECT_EQ(map.image().filter(), v1::IMAGE_FILTER_BILINEAR);
  EXPECT_EQ(map.mapping(), v1::SPHERE_MAPPING_LATITUDE_LONGITUDE);
}

TEST(ImageInfiniteOnTheWire, APortalIsItsCornersAndItsFluxPassesThroughIt) {
  const v1::Light light = light_of(kPortal + "\"string filename\" \"square.pfm\"");
  ASSERT_EQ(light.kind_case(), v1::Light::kImageInfinite);
  const v1::ImageInfiniteLight& sky = light.image_infinite();
  ASSERT_EQ(sky.portal_m_size(), 4);
  EXPECT_EQ(sky.portal_m(2).x(), 2);
  EXPECT_EQ(sky.portal_m(2).y(), 1);
  EXPECT_EQ(sky.portal_m(2).z(), 3);
  EXPECT_FALSE(light.has_area_m2());
  EXPECT_EQ(sky.map().image().name(), "square.pfm");
  EXPECT_EQ(sky.map().image().filter(), v1::IMAGE_FILTER_UNSPECIFIED);  // resampled
  // pi L A
  EXPECT_NEAR(light.power_lm(), kPi * 2 * 2, 1e-6);
  EXPECT_EQ(light.power_error_lm(), 0);
  const v1::Light direct =
      light_of(kPortal + "\"string filename\" \"square.pfm\" \"string filter\" \"nearest\"");
  EXPECT_EQ(direct.image_infinite().map().image().filter(), v1::IMAGE_FILTER_NEAREST);
  EXPECT_GT(direct.power_error_lm(), 0);
  EXPECT_NEAR(direct.power_lm(), kPi * 2 * 2, direct.power_error_lm());
}

TEST(ImageInfiniteOnTheWire, APortalOfAUniformSkyHasNoMap) {
  const v1::Light light = light_of(kPortal + "\"rgb L\" [1 2 3]");
  ASSERT_EQ(light.kind_case(), v1::Light::kImageInfinite);
  EXPECT_FALSE(light.image_infinite().has_map());
  EXPECT_EQ(light.image_infinite().portal_m_size(), 4);
  EXPECT_EQ(light.image_infinite().radiance_cd_m2().b(), 3);
}

}  // namespace
}  // namespace lucerna::testing
