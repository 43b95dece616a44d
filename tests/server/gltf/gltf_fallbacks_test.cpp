// Files that exporters write although the specification does not allow them, or that require what
// can be left out.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "gltf_fixture.h"

namespace lucerna {
namespace {

using testing::gltf_remarks;
using testing::GltfFile;
using testing::GltfFiles;
using ::testing::HasSubstr;
using testing::Json;

TEST(GltfExtensions, RequiredOnesWithAFallbackGetARemark) {
  for (const auto& [name, instead] :
       {std::pair{"KHR_materials_variants", "each mesh has its default material"},
        {"KHR_materials_pbrSpecularGlossiness", "pbrMetallicRoughness; without it"},
        {"KHR_materials_volume", "the materials without it"},
        {"KHR_texture_basisu", "the picture in \"source\""},
        {"KHR_xmp_json_ld", "ignored"},
        {"KHR_animation_pointer", "the values at rest"},
        {"KHR_physics_rigid_bodies", "ignored"},
        {"VRMC_vrm", "ignored"},
        {"CESIUM_primitive_outline", "ignored"},
        {"MSFT_packing_occlusionRoughnessMetallic", "the textures without it"}}) {
    GltfFile file;
    file.json["extensionsUsed"] = file.json["extensionsRequired"] = {name};
    EXPECT_THAT(gltf_remarks(file.scene()),
                HasSubstr(std::string("extension \"") + name + "\" is not modelled -> " + instead));
  }
  // Without these, vertices or lights would be wrong.
  for (const char* name : {"CESIUM_RTC", "KHR_node_visibility", "KHR_meshopt_compression"}) {
    GltfFile file;
    file.json["extensionsUsed"] = file.json["extensionsRequired"] = {name};
    EXPECT_THAT(file.error(), HasSubstr(name));
  }
  GltfFile webp;
  webp.json["extensionsUsed"] = webp.json["extensionsRequired"] = {"EXT_texture_webp"};
  EXPECT_EQ(webp.error(), "");
}

/// The angles of a spot, and the remarks of its file.
std::pair<SpotLightParams, std::string> spot(double inner, double outer) {
  GltfFile file;
  file.add_node(GltfFile::light_node(file.add_light(
      {{"type", "spot"}, {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}})));
  const SceneDescription scene = file.scene();
  return {std::get<SpotLightParams>(scene.lights.at(0).params), gltf_remarks(scene)};
}

TEST(GltfLights, AnglesWithFewDigitsEndAtTheirLimit) {
  constexpr double kRight = std::numbers::pi / 2;
  for (const double outer : {1.5708, 1.57079637, 1.571}) {
    const auto [light, remarks] = spot(0, outer);
    EXPECT_EQ(light.cone_half_angle_rad, kRight);
    // An exporter that holds floats made no mistake.
    EXPECT_EQ(remarks.find("/outerConeAngle: ") != std::string::npos, outer != 1.57079637) << outer;
  }
  const auto [light, remarks] = spot(0.78544, 0.7854);
  EXPECT_EQ(light.falloff_start_rad, 0.7854);
  EXPECT_THAT(remarks, HasSubstr("0.78544 rad, more than 0.7854 -> this limit"));
}

TEST(GltfLights, ConesOutOfOrderEndAtTheirLimit) {
  const auto [crossed, remark] = spot(1, 0.5);
  EXPECT_EQ(crossed.cone_half_angle_rad, 0.5);
  EXPECT_EQ(crossed.falloff_start_rad, 0.5);
  EXPECT_THAT(remark, HasSubstr("/innerConeAngle: 1 rad, more than 0.5 -> this limit"));
  const auto [narrow, other] = spot(0, 0);
  EXPECT_EQ(narrow.cone_half_angle_rad, 1e-6);
  EXPECT_THAT(other, HasSubstr("/outerConeAngle: 0 rad, less than 1e-06 -> this limit"));
}

TEST(GltfMaterials, TheFirstThreeOfFourEmissiveFactorsCount) {
  GltfFile file;
  file.json["materials"] = Json::array({{{"emissiveFactor", {1, 0.5, 0.25, 1}}}});
  Json triangle = file.triangle();
  triangle["material"] = 0;
  file.add_node({{"mesh", file.add_mesh(triangle)}});
  const SceneDescription scene = file.scene();
  EXPECT_EQ(scene.shapes.at(0).emission->radiance_cd_m2, Rgb(1, 0.5, 0.25));
  EXPECT_THAT(gltf_remarks(scene),
              HasSubstr("/emissiveFactor: 4 numbers, which glTF limits to 3 -> the first 3"));
}

/// Each byte as a percent escape.
std::string escaped(const std::string& bytes) {
  std::string text;
  for (const unsigned char c : bytes) text += fmt::format("%{:02x}", c);
  return text;
}

TEST(GltfFiles, DataUrisNeedNoBase64) {
  GltfFile file;
  file.add_node({{"mesh", file.add_mesh(file.triangle())}});
  const SceneDescription coded = file.scene();
  const auto load = [&](const std::string& uri) {
    const GltfFiles files;
    files.write("scene.gltf", file.text(uri));
    return files.load("scene.gltf");
  };
  const std::string base64 = absl::Base64Escape(file.bytes());
  for (const std::string& uri :
       {"data:application/octet-stream," + escaped(file.bytes()), "data:," + escaped(file.bytes()),
        "data:;charset=utf-8;BASE64," + base64, "data:;base64," + escaped(base64),
        "DATA:;base64," + base64}) {
    const auto scene = testing::value_of(load(uri));
    EXPECT_EQ(scene.objects.size() + scene.shapes.size(),
              coded.objects.size() + coded.shapes.size());
  }
}

TEST(GltfMaterials, SpecularGlossinessAloneIsASurfaceOfItsColours) {
  GltfFile file;
  file.json["extensionsUsed"] =
      file.json["extensionsRequired"] = {"KHR_materials_pbrSpecularGlossiness"};
  file.json["materials"] = Json::array({{{"extensions",
                                          {{"KHR_materials_pbrSpecularGlossiness",
                                            {{"diffuseFactor", {0.5, 0.25, 0.125, 1}},
                                             {"specularFactor", {0.04, 0.02, 0.08}},
                                             {"glossinessFactor", 0.75}}}}}}});
  Json triangle = file.triangle();
  triangle["material"] = 0;
  file.add_node({{"mesh", file.add_mesh(triangle)}});
  const SceneDescription scene = file.scene();
  const auto& surface = std::get<GltfSurfaceParams>(scene.materials.back().params);
  EXPECT_EQ(surface.base.constant, Rgb(0.5, 0.25, 0.125));
  EXPECT_EQ(surface.surface.constant, Rgb(1, 0.25, 0));  // roughness, no metal
  EXPECT_NEAR(surface.specular_colour.constant.r, 1, 1e-12);
  EXPECT_NEAR(surface.specular_colour.constant.b, 2, 1e-12);
}

TEST(GltfTextures, ThePictureOfAnExtensionIsReadIfTheServerReadsItOrThereIsNoOther) {
  GltfFile file;
  file.json["images"] = Json::array(
      {{{"uri", "data:image/png;base64," + absl::Base64Escape(testing::png(1, 1, {9, 9, 9, 255}))}},
       {{"uri", "data:image/png;base64," +
                    absl::Base64Escape(testing::png(2, 1, {9, 9, 9, 255, 9, 9, 9, 255}))}}});
  file.json["materials"] =
      Json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
  Json triangle = file.triangle();
  triangle["attributes"]["TEXCOORD_0"] = file.add_floats({0, 0, 1, 0, 0, 1}, "VEC2");
  triangle["material"] = 0;
  file.add_node({{"mesh", file.add_mesh(triangle)}});
  const auto width = [&](const Json& texture) {
    file.json["textures"] = Json::array({texture});
    const SceneDescription scene = file.scene();
    return scene.textures.pictures().front().texels->width();
  };
  const Json other = {{"EXT_texture_webp", {{"source", 1}}}};
  EXPECT_EQ(width({{"extensions", other}}), 2);
  EXPECT_EQ(width({{"source", 0}, {"extensions", other}}), 2);  // "source" is for other readers
  const Json unread = {{"MSFT_texture_dds", {{"source", 1}}}};
  EXPECT_EQ(width({{"source", 0}, {"extensions", unread}}), 1);
}

}  // namespace
}  // namespace lucerna
