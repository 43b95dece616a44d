// ListLights for goniometric lights: with a picture, with a photometric file, without either.
#include <filesystem>
#include <fstream>

#include "service_fixture.h"
#include "tests/paths.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna::testing {
namespace {

TEST(GoniometricService, ListLightsReportsTheDistribution) {
  const SceneFiles files;
  std::filesystem::copy_file(test_data("reference/gonio.exr"), files.path() / "gonio.exr");
  // 100 cd over the lower half: 200 pi lm.
  files.write("lamps/down.ies",
              "IESNA:LM-63-1995\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n");
  files.write("scene.pbrt",
              "WorldBegin\n"
              "Translate 1 2 3\n"
              "LightSource \"goniometric\" \"string filename\" \"gonio.exr\" \"rgb I\" [2 2 2]\n"
              "LightSource \"goniometric\" \"string filename\" \"gonio.exr\"\n"
              "  \"string mapping\" \"latlong\" \"string filter\" \"bilinear\" \"float power\" 80\n"
              "LightSource \"goniometric\" \"string filename\" \"lamps/down.ies\" "
              "\"float scale\" 0.5\n"
              "LightSource \"goniometric\" \"rgb I\" [7 7 7]\n");
  Service service(scenes_in(files.path()));
  const auto response = service.answer(about<v1::ListLightsRequest>(service.load("scene.pbrt")));
  ASSERT_EQ(response.lights_size(), 4);
  for (const v1::Light& light : response.lights()) {
    EXPECT_EQ(light.kind_case(), v1::Light::kGoniometric);
    EXPECT_TRUE(light.delta());
    EXPECT_FALSE(light.has_area_m2());
    EXPECT_EQ(light.goniometric().position_m().y(), 2);
    EXPECT_EQ(light.bounds().lower_m().z(), 3);
    EXPECT_EQ(light.power_error_lm(), 0);
  }

  const v1::GoniometricLight& picture = response.lights(0).goniometric();
  EXPECT_EQ(picture.distribution_case(), v1::GoniometricLight::kImage);
  EXPECT_EQ(picture.image().image().name(), "gonio.exr");
  EXPECT_EQ(picture.image().image().width(), 64U);
  EXPECT_EQ(picture.image().image().height(), 64U);
  EXPECT_EQ(picture.image().image().filter(), v1::IMAGE_FILTER_NEAREST);
  EXPECT_EQ(picture.image().mapping(), v1::SPHERE_MAPPING_EQUAL_AREA);
  EXPECT_DOUBLE_EQ(picture.intensity().g(), 2);
  EXPECT_GT(response.lights(0).power_lm(), 0);

  const v1::GoniometricLight& other = response.lights(1).goniometric();
  EXPECT_EQ(other.image().image().filter(), v1::IMAGE_FILTER_BILINEAR);
  EXPECT_EQ(other.image().mapping(), v1::SPHERE_MAPPING_LATITUDE_LONGITUDE);
  EXPECT_NEAR(response.lights(1).power_lm(), 80, 1e-9);

  const v1::GoniometricLight& luminaire = response.lights(2).goniometric();
  EXPECT_EQ(luminaire.distribution_case(), v1::GoniometricLight::kPhotometricFile);
  EXPECT_EQ(luminaire.photometric_file().name(), "lamps/down.ies");
  EXPECT_EQ(luminaire.photometric_file().format(), "IES LM-63-1995, type C");
  EXPECT_NEAR(luminaire.photometric_file().flux_lm(), 200 * kPi, 1e-9);
  EXPECT_DOUBLE_EQ(luminaire.intensity().g(), 0.5);
  EXPECT_NEAR(response.lights(2).power_lm(), 100 * kPi, 1e-9);

  const v1::GoniometricLight& isotropic = response.lights(3).goniometric();
  EXPECT_EQ(isotropic.distribution_case(), v1::GoniometricLight::DISTRIBUTION_NOT_SET);
  EXPECT_DOUBLE_EQ(isotropic.intensity().b(), 7);
  EXPECT_NEAR(response.lights(3).power_lm(), 28 * kPi, 1e-9);
}

}  // namespace
}  // namespace lucerna::testing
