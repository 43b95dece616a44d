// Pictures and colours of .pbrt files as other programs write them, and pictures that cannot be
// read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "tests/paths.h"
#include "tests/server/extremes/file_scenes.h"
#include "tests/server/files/photometric_texts.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using testing::even_pfm;
using testing::FileScene;
using testing::flux_lm;
using ::testing::HasSubstr;
using testing::message;
using testing::remarks_of;
using testing::scene_of;
using testing::written;

SceneDescription load_data(const std::string& name) {
  auto assets = testing::value_of(AssetReader::open(test_data("pictures")));
  return testing::value_of(load_pbrt(assets, name, {}));
}

/// The radiance of the only sky towards +x and a little up [cd/m2].
Rgb sky_of(const SceneDescription& scene) {
  const auto& sky = std::get<ImageInfiniteLightParams>(scene.lights.at(0).params);
  return sky.map->lookup({1, 0.1, 0.1}) * sky.radiance_cd_m2;
}

TEST(PbrtPictures, RadianceSkiesMeanWhatTheirHeadersSay) {
  const SceneDescription exposed = load_data("hdr_exposure.pbrt");
  EXPECT_EQ(sky_of(exposed), Rgb(1));
  EXPECT_EQ(remarks_of(exposed), "");
  // The second row from the top: +Y stores rows from the bottom.
  const SceneDescription upright = load_data("hdr_plusY.pbrt");
  EXPECT_EQ(sky_of(upright), Rgb(2, 1.25, 0.5));
  EXPECT_EQ(remarks_of(upright), "");
  // X = Y = Z = 2.
  const SceneDescription xyz = load_data("hdr_xyze.pbrt");
  EXPECT_NEAR(luminance(sky_of(xyz)), 2, 1e-6);
  EXPECT_EQ(remarks_of(xyz), "");
}

TEST(PbrtPictures, TheLuminanceOfWhiteScalesSkiesAndAreaLights) {
  OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
  spec.attribute("whiteLuminance", 50.0F);
  const std::string bytes = written("a.exr", spec, std::vector<float>{1, 1, 1});
  const FileScene panel =
      scene_of("AreaLightSource \"diffuse\" \"string filename\" \"a.exr\" Shape \"disk\"",
               {{"a.exr", bytes}});
  ASSERT_TRUE(panel.status.ok()) << panel.status;
  EXPECT_NEAR(flux_lm(*panel.scene), 50 * std::numbers::pi * std::numbers::pi, 1e-4);
  EXPECT_THAT(panel.remarks, HasSubstr("50 cd/m2 -> its texels times this luminance"));
  const FileScene slide = scene_of(
      "LightSource \"projection\" \"string projection\" \"orthographic\" \"string filename\" "
      "\"a.exr\"",
      {{"a.exr", bytes}});
  ASSERT_TRUE(slide.status.ok()) << slide.status;
  EXPECT_NEAR(flux_lm(*slide.scene), 1, 1e-6);
  EXPECT_THAT(slide.remarks, HasSubstr("50 cd/m2 -> a texel of 1 is the light's level"));
}

TEST(PbrtPictures, RgbOfTheColourSpaceIsConvertedToRec709) {
  // 4 pi times the luminances of the primaries.  [BT2020]
  const SceneDescription scene = load_data("colorspace_rec2020.pbrt");
  const double expected[]{3.3012, 8.5200, 0.7452};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(4 * std::numbers::pi *
                    luminance(std::get<PointLightParams>(scene.lights.at(i).params).intensity_cd),
                expected[i], 1e-4);
  EXPECT_THAT(remarks_of(scene), HasSubstr("\"rgb I\" = [1 0 0] is outside of Rec. 709 -> linear "
                                           "RGB [1.235 0 0] of the same luminance"));
}

TEST(PbrtPictures, ColourSpacesFollowBlocksAndIgnoreCase) {
  const auto scene = testing::value_of(testing::load_world(
      "LightSource \"point\" \"rgb I\" [0.5 0.5 0.25] "
      "AttributeBegin ColorSpace \"REC2020\" LightSource \"point\" \"rgb I\" [0.5 0.5 0.25] "
      "AttributeEnd LightSource \"point\" \"rgb I\" [0.5 0.5 0.25] "
      "ColorSpace \"dci-p3\" LightSource \"point\" \"rgb I\" [1 1 1]"));
  const auto intensity = [&](std::size_t i) {
    return std::get<PointLightParams>(scene.lights.at(i).params).intensity_cd;
  };
  EXPECT_EQ(intensity(0), Rgb(0.5, 0.5, 0.25));
  // [BT2087]
  EXPECT_NEAR(intensity(1).r, (1.6605 - 0.5876) / 2 - 0.0728 / 4, 1e-4);
  EXPECT_EQ(intensity(2), intensity(0));
  EXPECT_NEAR(intensity(3).r, 1, 1e-12);  // the white is D65, as in pbrt-v4
  EXPECT_EQ(remarks_of(scene), "");
}

TEST(PbrtPictures, ReflectancesOfAnotherWhiteKeepWhite) {
  const auto scene = testing::value_of(testing::load_world(
      "ColorSpace \"aces2065-1\" Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5] "
      "Shape \"sphere\" LightSource \"point\" \"rgb I\" [1 1 1]"));
  const auto& grey = std::get<DiffuseParams>(scene.materials.back().params).reflectance.constant;
  EXPECT_NEAR(grey.r, 0.5, 1e-12);
  EXPECT_NEAR(grey.b, 0.5, 1e-12);
  const auto light = std::get<PointLightParams>(scene.lights.at(0).params).intensity_cd;
  EXPECT_NEAR(luminance(light), 1, 1e-12);
  EXPECT_GT(light.r, light.b);  // 6000 K
}

const std::pair<const char*, std::string> kUnreadable[]{
    {"none.gif", "GIF89a"},
    {"words.png", "no picture"},
    {"cut.pfm", even_pfm(4, 4, 1).substr(0, 40)},
    {"nan.pfm", even_pfm(4, 4, NAN)}};

TEST(PbrtPictures, AnUnreadableTextureIsGrey) {
  for (const auto& [name, bytes] : kUnreadable) {
    SCOPED_TRACE(name);
    const std::string file = "\"imagemap\" \"string filename\" \"" + std::string(name) + "\" ";
    const testing::SceneFiles files;
    files.write(name, bytes);
    files.write("scene.pbrt", "WorldBegin\nTexture \"c\" \"spectrum\" " + file +
                                  "Texture \"a\" \"float\" " + file +
                                  "Material \"diffuse\" \"texture reflectance\" \"c\" "
                                  "Shape \"disk\" \"texture alpha\" \"a\"");
    const auto scene = testing::value_of(files.load("scene.pbrt"));
    EXPECT_EQ(std::get<DiffuseParams>(scene.materials.back().params).reflectance.constant,
              Rgb(0.5));
    // A grey alpha would let half of the rays pass.
    EXPECT_TRUE(scene.shapes.at(0).alpha.is_constant());
    EXPECT_EQ(scene.shapes.at(0).alpha.constant, 1);
    EXPECT_THAT(remarks_of(scene), HasSubstr("2:35 \"string filename\": " + std::string(name)));
    EXPECT_THAT(remarks_of(scene), HasSubstr("-> grey 0.5; as an alpha, 1"));
  }
}

TEST(PbrtPictures, AnUnreadableNormalMapIsLeftOut) {
  const testing::SceneFiles files;
  files.write("n.png", "no picture");
  files.write("scene.pbrt",
              "WorldBegin Material \"diffuse\" \"string normalmap\" \"n.png\" Shape \"sphere\"");
  const auto scene = testing::value_of(files.load("scene.pbrt"));
  EXPECT_LT(scene.materials.back().normal_map, 0);
  EXPECT_THAT(remarks_of(scene), HasSubstr("-> no normal map"));
}

TEST(PbrtPictures, ALightWithAnUnreadablePictureIsLeftOut) {
  const std::string area = "AreaLightSource \"diffuse\" \"string filename\" FILE ";
  for (std::string text :
       {std::string("LightSource \"infinite\" \"string filename\" FILE"),
        std::string("LightSource \"infinite\" \"string filename\" FILE \"float illuminance\" 100"),
        std::string("LightSource \"infinite\" \"string filename\" FILE "
                    "\"point3 portal\" [-1 -1 2  -1 1 2  1 1 2  1 -1 2]"),
        std::string("LightSource \"goniometric\" \"string filename\" FILE \"float power\" 5"),
        std::string("LightSource \"projection\" \"string filename\" FILE"), area + "Shape \"disk\"",
        area + "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0 1 -1 0 1 1 0] Shape \"sphere\""})
    for (const auto& [name, bytes] : kUnreadable) {
      SCOPED_TRACE(text);
      std::string named = text + "\nLightSource \"point\"";
      named.replace(named.find("FILE"), 4, '"' + std::string(name) + '"');
      const FileScene scene = scene_of(named, {{name, bytes}});
      ASSERT_TRUE(scene.status.ok()) << scene.status;
      ASSERT_EQ(scene.scene->lights().size(), 1U);  // the other light still shines
      EXPECT_NEAR(flux_lm(*scene.scene), 4 * std::numbers::pi, 1e-9);
      EXPECT_THAT(scene.remarks, HasSubstr(name));
      EXPECT_THAT(scene.remarks, HasSubstr("-> the light is left out"));
    }
}

TEST(PbrtPictures, FilesThatLightsShareCountOnce) {
  const std::string area = "AreaLightSource \"diffuse\" ", disk = "Shape \"disk\" ";
  const std::string goniometric = "LightSource \"goniometric\" \"string filename\" ";
  const std::string picture = "\"string filename\" \"a.pfm\" ";
  const std::tuple<std::string, const char*, const char*> kCases[] = {
      {"LightSource \"infinite\" " + picture, "images", nullptr},
      {"LightSource \"projection\" " + picture, "images", nullptr},
      {goniometric + "\"a.pfm\" ", "images", nullptr},
      {goniometric + "\"a.pfm\" ", "intensity maps", nullptr},
      {area + picture + disk, "images", "1 pictures of lights"},
      {goniometric + "\"a.ies\" ", "photometric webs", "1 luminaires"},
      {area + "\"string profile\" \"a.ies\" " + disk, "photometric webs", "1 luminaires"},
  };
  for (const auto& [light, name, why] : kCases) {
    SCOPED_TRACE(light + name);
    const auto part = [name = std::string(name)](const std::string& text) {
      const FileScene loaded =
          scene_of(text, {{"a.pfm", even_pfm(16, 16, 1)}, {"a.ies", testing::Ies().text()}});
      if (!loaded.status.ok()) throw std::runtime_error(message(loaded.status));
      const auto parts = loaded.scene->parts();
      EXPECT_EQ(std::ranges::count(parts, name, &ScenePart::name), 1);
      return *std::ranges::find(parts, name, &ScenePart::name);
    };
    const ScenePart one = part(light), two = part(light + light);
    EXPECT_GT(one.bytes, 0U);
    EXPECT_EQ(two.bytes, one.bytes);
    if (why != nullptr) {
      EXPECT_EQ(two.why, why);
    }
  }
}

TEST(PbrtPictures, AMissingPictureAndLimitsAreStillErrors) {
  const std::string texture =
      "Texture \"c\" \"spectrum\" \"imagemap\" \"string filename\" \"c.pfm\" ";
  EXPECT_EQ(scene_of(texture).status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(scene_of(texture, {{"c.pfm", "PF\n64000 64000\n-1.0\n"}}).status.code(),
            absl::StatusCode::kResourceExhausted);
}

TEST(PbrtPictures, ColoursOtherThanSrgbAreReported) {
  // gAMA 1.0 and the chromaticities of Adobe RGB, written before the texels of a PNG file.
  const OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::UINT8);
  const std::string png = written("a.png", spec, std::vector<std::uint8_t>{9, 8, 7});
  const auto with = [&](const std::string& chunk) {
    constexpr std::size_t kAfterHeader = 33;
    std::string bytes = png;
    return bytes.insert(kAfterHeader, chunk);
  };
  const auto remarks = [&](const std::string& bytes, const std::string& parameters = "") {
    return scene_of(
               "Texture \"c\" \"spectrum\" \"imagemap\" \"string filename\" \"c.png\"" + parameters,
               {{"c.png", bytes}})
        .remarks;
  };
  const std::string gamma("\0\0\0\4gAMA\0\1\206\240\061\350\226\137", 16);
  EXPECT_EQ(remarks(png), "");
  EXPECT_THAT(remarks(with(gamma)), HasSubstr("c.png has a gamma of 1 -> treated as sRGB"));
  // The parameter says what the codes mean.
  EXPECT_EQ(remarks(with(gamma), " \"string encoding\" \"linear\""), "");
}

}  // namespace
}  // namespace lucerna
