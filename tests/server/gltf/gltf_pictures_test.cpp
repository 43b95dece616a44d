// Pictures of glTF files of other formats and names, and pictures that cannot be read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/paths.h"
#include "tests/server/gltf/gltf_fixture.h"

namespace lucerna {
namespace {

using testing::gltf_remarks;
using testing::GltfFile;
using testing::GltfFiles;
using ::testing::HasSubstr;
using testing::Json;
using testing::png;

/// A triangle with a material and one picture.
GltfFile painted(const Json& material) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["attributes"]["TEXCOORD_0"] = file.add_floats({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["material"] = 0;
  file.json["materials"] = Json::array({material});
  file.json["textures"] = Json::array({{{"source", 0}}});
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  return file;
}

void add_picture(GltfFile& file, const std::string& bytes) {
  file.json["images"].push_back({{"bufferView", file.add_view(bytes)}});
}

TEST(GltfPictureFormats, TheFirstBytesDecideAndNotTheName) {
  auto assets = testing::value_of(AssetReader::open(test_data("pictures")));
  const auto scene = testing::value_of(load_gltf(assets, "gltf_png_named_jpg.gltf", {}, {}, {}));
  const auto& emission = scene.shapes.at(0).emission;
  ASSERT_TRUE(emission && emission->picture);
  // pi times the area of 4 m2 times the mean of the texels is 6.319 lm.
  EXPECT_NEAR(kPi * 4 * luminance(emission->picture->image->mean()), 6.319, 1e-3);
  EXPECT_EQ(
      gltf_remarks(scene),
      "gltf_png_named_jpg.gltf: the scene has no camera -> one at the origin that looks along "
      "-z\n");
}

/// One red texel, lossless.
std::string webp() {
  std::ifstream in(test_data("pictures/red.webp"), std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(GltfPictureFormats, WebpIsReadFromItsExtension) {
  GltfFile file = painted({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  add_picture(file, png(1, 1, {0, 255, 0, 255}));
  add_picture(file, webp());
  const auto base = [](const SceneDescription& scene) {
    return scene.textures(std::get<GltfSurfaceParams>(scene.materials.at(0).params).base,
                          TexturePoint{.uv = {0.5, 0.5}});
  };
  EXPECT_EQ(base(file.scene()), Rgb(0, 1, 0));
  file.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
  file.json["extensionsUsed"] = file.json["extensionsRequired"] = Json::array({"EXT_texture_webp"});
  const SceneDescription scene = file.scene();
  EXPECT_NEAR(base(scene).r, 1, 1e-6);
  EXPECT_LT(base(scene).g, 1e-3);  // the encoder writes the code 1
  EXPECT_EQ(gltf_remarks(scene),
            "scene.gltf: the scene has no camera -> one at the origin that looks along -z\n");
  file.json["textures"][0].erase("source");
  EXPECT_NEAR(base(file.scene()).r, 1, 1e-6);
  file.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 2;
  EXPECT_THAT(file.error(), HasSubstr("/textures/0/extensions/EXT_texture_webp/source: found 2"));
}

TEST(GltfPictureFormats, UnreadableTexturesFollowTheirRole) {
  const Json texture = {{"index", 0}};
  GltfFile file = painted({{"pbrMetallicRoughness",
                            {{"baseColorTexture", texture},
                             {"baseColorFactor", {0.5, 1, 1, 0.75}},
                             {"metallicRoughnessTexture", texture},
                             {"roughnessFactor", 0.25}}},
                           {"normalTexture", texture},
                           {"alphaMode", "BLEND"}});
  add_picture(file, "GIF89a, or whatever it is");
  const SceneDescription scene = file.scene();
  const Material& material = scene.materials.at(0);
  const auto& surface = std::get<GltfSurfaceParams>(material.params);
  EXPECT_EQ(scene.textures(surface.base, TexturePoint{}), Rgb(0.25, 0.5, 0.5));
  ASSERT_TRUE(surface.surface.is_constant());
  EXPECT_EQ(surface.surface.constant, Rgb(1, 0.25, 1));
  EXPECT_LT(material.normal_map, 0);
  ASSERT_TRUE(scene.shapes.at(0).alpha.is_constant());
  EXPECT_EQ(scene.shapes.at(0).alpha.constant, 0.75);
  const std::string remarks = gltf_remarks(scene);
  for (const char* instead : {"-> grey 0.5 times the factor", "-> only the factor\n",
                              "-> only the factor of the alpha", "-> no normal map"})
    EXPECT_THAT(remarks, HasSubstr(instead));
  EXPECT_THAT(remarks, HasSubstr("scene.gltf#/images/0: "));
}

TEST(GltfPictureFormats, ALightWithAnUnreadablePictureIsLeftOut) {
  GltfFile file = painted({{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}});
  add_picture(file, "no picture");
  const SceneDescription scene = file.scene();
  EXPECT_FALSE(scene.shapes.at(0).emission.has_value());
  EXPECT_THAT(gltf_remarks(scene), HasSubstr("unknown kind of image"));
  EXPECT_THAT(gltf_remarks(scene), HasSubstr("-> the light is left out"));

  GltfFile sky;
  for (int f = 0; f < 6; ++f) add_picture(sky, f == 3 ? "no picture" : png(1, 1, {9, 9, 9, 255}));
  sky.json["extensions"]["EXT_lights_image_based"]["lights"] =
      Json::array({{{"intensity", 10},
                    {"specularImageSize", 1},
                    {"specularImages", Json::array({Json::array({0, 1, 2, 3, 4, 5})})},
                    {"irradianceCoefficients", Json::array()}}});
  sky.json["scenes"] =
      Json::array({{{"extensions", {{"EXT_lights_image_based", {{"light", 0}}}}}}});
  const SceneDescription dark = sky.scene();
  EXPECT_TRUE(dark.lights.empty());
  EXPECT_THAT(gltf_remarks(dark), HasSubstr("-> the light is left out"));
}

}  // namespace
}  // namespace lucerna
