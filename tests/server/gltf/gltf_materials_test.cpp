// Materials and textures of glTF files.
#include <gmock/gmock.h>

#include <numbers>

#include "gltf_fixture.h"
#include "server/scene/scene.h"

namespace lucerna {
namespace {

using testing::gltf_remarks;
using testing::GltfFile;
using testing::GltfFiles;
using ::testing::HasSubstr;
using testing::Json;
using testing::message_of;
using ::testing::Not;
using testing::png;

/// A triangle with (u, v) 0,0 and 1,0 and 0,1, which has a material.
GltfFile surfaced(const Json& material) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["attributes"]["TEXCOORD_0"] = file.add_floats({0, 0, 1, 0, 0, 1}, "VEC2");
  primitive["attributes"]["TEXCOORD_1"] = file.add_floats({0.5, 0.5, 1, 0, 0, 1}, "VEC2");
  primitive["material"] = 0;
  file.json["materials"] = Json::array({material});
  file.json["textures"] = Json::array({{{"source", 0}}});
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  return file;
}

/// The same with a picture of 2 x 2 texels, rows from the top.
GltfFile textured(const Json& material, const std::vector<std::uint8_t>& rgba) {
  GltfFile file = surfaced(material);
  file.json["images"] =
      Json::array({{{"bufferView", file.add_view(png(2, 2, rgba))}, {"mimeType", "image/png"}}});
  file.json["samplers"] = Json::array({{{"magFilter", 9728}}});
  file.json["textures"][0]["sampler"] = 0;
  return file;
}

/// Above 255 0 0 and 0 255 0, below 0 0 255 and 188 188 188.
const std::vector<std::uint8_t> kFour{255, 0, 0,   255, 0,   255, 0,   0,
                                      0,   0, 255, 128, 188, 188, 188, 64};

const Material& material_of(const SceneDescription& scene) {
  return scene.materials.at(scene.shapes.at(0).material);
}

const GltfSurfaceParams& surface_of(const SceneDescription& scene) {
  return std::get<GltfSurfaceParams>(material_of(scene).params);
}

Json with(const std::string& extension, const Json& values) {
  return {{"extensions", {{extension, values}}}};
}

TEST(GltfMaterials, WithoutFacetsTheyAreDiffuse) {
  Json material = with("KHR_materials_specular", {{"specularFactor", 0}});
  material["pbrMetallicRoughness"] = {{"baseColorFactor", {0.1, 0.2, 0.3, 1}},
                                      {"metallicFactor", 0}};
  const SceneDescription scene = surfaced(material).scene();
  ASSERT_NE(material_of(scene).plain_diffuse(), nullptr);
  EXPECT_EQ(*material_of(scene).plain_diffuse(), Rgb(0.1, 0.2, 0.3));
  EXPECT_FALSE(scene.shapes[0].emission);
  EXPECT_FALSE(scene.shapes[0].has_uv);
}

TEST(GltfMaterials, TheDefaultIsARoughWhiteMetal) {
  const SceneDescription scene = surfaced(Json::object()).scene();
  EXPECT_EQ(surface_of(scene).base.constant, Rgb(1.0));
  EXPECT_EQ(surface_of(scene).surface.constant, Rgb(1.0));
}

TEST(GltfMaterials, ExtensionsSetTheirFactors) {
  const Json material = {
      {"pbrMetallicRoughness", {{"metallicFactor", 0.25}, {"roughnessFactor", 0.5}}},
      {"extensions",
       {{"KHR_materials_ior", {{"ior", 1.33}}},
        {"KHR_materials_specular", {{"specularFactor", 0.75}, {"specularColorFactor", {1, 2, 3}}}},
        {"KHR_materials_transmission", {{"transmissionFactor", 0.125}}},
        {"KHR_materials_clearcoat",
         {{"clearcoatFactor", 0.375}, {"clearcoatRoughnessFactor", 0.625}}},
        {"KHR_materials_anisotropy",
         {{"anisotropyStrength", 0.875}, {"anisotropyRotation", 0.5}}}}}};
  const SceneDescription scene = surfaced(material).scene();
  const GltfSurfaceParams& s = surface_of(scene);
  EXPECT_EQ(s.surface.constant.g, 0.5);
  EXPECT_EQ(s.surface.constant.b, 0.25);
  EXPECT_EQ(s.ior, 1.33);
  EXPECT_EQ(s.specular.constant, 0.75);
  EXPECT_EQ(s.specular_colour.constant, Rgb(1, 2, 3));
  EXPECT_EQ(s.transmission.constant, 0.125);
  EXPECT_EQ(s.coat.constant, 0.375);
  EXPECT_EQ(s.coat_roughness.constant.g, 0.625);
  EXPECT_EQ(s.anisotropy, 0.875);
  EXPECT_EQ(s.anisotropy_turn_rad, 0.5);
  EXPECT_TRUE(bsdf_of(material_of(scene), scene.textures, {}).sides() == Side::kBoth);
}

// Along the normal a microfacet lobe has the value F / (4 pi alpha_x alpha_y).
TEST(GltfMaterials, RoughnessIsSquaredAndIorSetsTheReflectance) {
  const auto value = [](const Json& material) {
    const SceneDescription scene = surfaced(material).scene();
    return bsdf_of(material_of(scene), scene.textures, {}).value({0, 0, 1}, {0, 0, 1}).g;
  };
  Json material = with("KHR_materials_ior", {{"ior", 2}});
  material["pbrMetallicRoughness"] = {
      {"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.5}};
  EXPECT_NEAR(value(material), 1 / 9.0 / (4 * std::numbers::pi * 0.0625), 1e-12);
  // Strength 1 makes the roughness along u 1.
  material["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 1}};
  EXPECT_NEAR(value(material), 1 / 9.0 / (4 * std::numbers::pi * 0.25), 1e-12);
}

TEST(GltfMaterials, ClearSmoothSheetsArePanes) {
  Json glass = {{"extensions",
                 {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                  {"KHR_materials_ior", {{"ior", 1.45}}}}},
                {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}}};
  const SceneDescription scene = surfaced(glass).scene();
  const auto* pane = std::get_if<ThinDielectricParams>(&material_of(scene).params);
  ASSERT_NE(pane, nullptr);
  EXPECT_EQ(pane->eta.constant, 1.45);
  const auto built = testing::value_of(Scene::build(scene));
  EXPECT_TRUE(built->geometry().has_panes());
  // Tinted, rough and partly diffuse sheets are not.
  for (const Json& change :
       {Json{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0.9, 1, 1}}}}},
        Json{{"pbrMetallicRoughness", {{"roughnessFactor", 0.1}}}},
        Json{{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}}}}}}) {
    Json other = glass;
    other.merge_patch(change);
    const SceneDescription sheet = surfaced(other).scene();
    EXPECT_NE(std::get_if<GltfSurfaceParams>(&material_of(sheet).params), nullptr) << change;
  }
}

TEST(GltfMaterials, LightsWithAlphaEmitInItsShare) {
  Json material = {{"emissiveFactor", {1, 1, 1}},
                   {"alphaMode", "BLEND"},
                   {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.25}}}}};
  const SceneDescription scene = surfaced(material).scene();
  EXPECT_EQ(scene.shapes[0].alpha.constant, 0.25);
  EXPECT_TRUE(scene.shapes[0].emission.has_value());
  EXPECT_THAT(gltf_remarks(scene), Not(HasSubstr("alpha")));
}

TEST(GltfTextures, BaseColoursAreCodedAndHaveAFactor) {
  const GltfFile file = textured(
      {{"pbrMetallicRoughness",
        {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {0.5, 0.25, 0.125, 1}}}}},
      kFour);
  const SceneDescription scene = file.scene();
  const ShapeDescription& shape = scene.shapes.at(0);
  EXPECT_TRUE(shape.has_uv);
  // v = 0 of the file is the top of the picture, which is v = 1 here.
  EXPECT_EQ(testing::mesh_of(shape).corner_uv[0], (Vec2f{0, 1}));
  EXPECT_EQ(testing::mesh_of(shape).corner_uv[2], (Vec2f{0, 0}));
  const auto at = [&](double u, double v) {
    return scene.textures(surface_of(scene).base, {.uv = {u, v}});
  };
  EXPECT_EQ(at(0.25, 0.75), Rgb(0.5, 0, 0));
  EXPECT_EQ(at(0.75, 0.75), Rgb(0, 0.25, 0));
  // The code 188 is 0.5029 of sRGB.
  EXPECT_NEAR(at(0.75, 0.25).r, 0.5 * 0.50289, 1e-5);
  EXPECT_THAT(gltf_remarks(scene), Not(HasSubstr("alpha")));
}

TEST(GltfTextures, RoughnessIsGreenAndMetalIsBlue) {
  const GltfFile file = textured({{"pbrMetallicRoughness",
                                   {{"metallicRoughnessTexture", {{"index", 0}}},
                                    {"metallicFactor", 0.5},
                                    {"roughnessFactor", 0.25}}}},
                                 kFour);
  const SceneDescription scene = file.scene();
  const Rgb grey = scene.textures(surface_of(scene).surface, {.uv = {0.75, 0.25}});
  // Linear.
  EXPECT_NEAR(grey.g, 188 / 255.0 * 0.25, 1e-7);
  EXPECT_NEAR(grey.b, 188 / 255.0 * 0.5, 1e-7);
}

TEST(GltfTextures, NormalMapsHaveAScale) {
  const GltfFile file = textured({{"normalTexture", {{"index", 0}, {"scale", 0.5}}}}, kFour);
  const SceneDescription scene = file.scene();
  EXPECT_EQ(material_of(scene).normal_scale, 0.5);
  const ColourValue map{{}, material_of(scene).normal_map};
  ASSERT_GE(map.texture, 0);
  EXPECT_NEAR(scene.textures(map, {.uv = {0.75, 0.25}}).r, 188 / 255.0, 1e-7);
}

// The specification's matrices by hand: u becomes 0.25 + 0.5 v and v becomes 0.75 - 0.5 u.
TEST(GltfTextures, TransformsAndSamplers) {
  const Json transform = {
      {"offset", {0.25, 0.75}}, {"rotation", std::numbers::pi / 2}, {"scale", {0.5, 0.5}}};
  GltfFile file =
      textured({{"pbrMetallicRoughness",
                 {{"baseColorTexture",
                   {{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}}}}}},
               kFour);
  file.json["samplers"][0]["wrapS"] = 33071;
  file.json["samplers"][0]["wrapT"] = 33648;
  const SceneDescription scene = file.scene();
  const auto& t = std::get<ImageTexture>(
      scene.textures.nodes()[static_cast<std::size_t>(surface_of(scene).base.texture)]);
  EXPECT_EQ(t.wrap_s, TextureWrap::kClamp);
  EXPECT_EQ(t.wrap_t, TextureWrap::kMirror);
  EXPECT_EQ(t.filter, TextureFilter::kNearest);
  // (0.5, 0.25) of the file, whose v runs downwards.
  const Vec2 st = t.mapping({.uv = {0.5, 0.75}});
  EXPECT_NEAR(st.x, 0.25 + 0.5 * 0.25, 1e-12);
  EXPECT_NEAR(st.y, 1 - (0.75 - 0.5 * 0.5), 1e-12);
}

TEST(GltfTextures, OneSetOfCoordinatesIsUsed) {
  const GltfFile file = textured({{"pbrMetallicRoughness",
                                   {{"baseColorTexture", {{"index", 0}, {"texCoord", 1}}},
                                    {"metallicRoughnessTexture", {{"index", 0}}}}}},
                                 kFour);
  const SceneDescription scene = file.scene();
  EXPECT_EQ(testing::mesh_of(scene.shapes.at(0)).corner_uv[0], (Vec2f{0.5, 0.5}));
  EXPECT_TRUE(surface_of(scene).surface.is_constant());
  EXPECT_THAT(gltf_remarks(scene),
              HasSubstr("scene.gltf#/materials/0/pbrMetallicRoughness/metallicRoughnessTexture: a "
                        "texture of TEXCOORD_0 beside those of TEXCOORD_1 -> only its factor is "
                        "applied"));
}

TEST(GltfTextures, MissingCoordinatesAreReported) {
  const GltfFile file = textured(
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 7}}}}}}, kFour);
  EXPECT_THAT(gltf_remarks(file.scene()),
              HasSubstr("scene.gltf#/meshes/0/primitives/0/attributes: TEXCOORD_7, which a texture "
                        "of the material needs, is missing"));
}

TEST(GltfTextures, BesideAnEmissivePictureTheyShareItsCoordinates) {
  Json material = {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                   {"emissiveFactor", {1, 1, 1}},
                   {"emissiveTexture", {{"index", 0}}}};
  SceneDescription scene = textured(material, kFour).scene();
  EXPECT_FALSE(surface_of(scene).base.is_constant());
  EXPECT_TRUE(scene.shapes.at(0).has_uv);
  material["emissiveTexture"]["extensions"]["KHR_texture_transform"] = {{"scale", {0.5, 0.5}}};
  scene = textured(material, kFour).scene();
  EXPECT_TRUE(surface_of(scene).base.is_constant());
  EXPECT_THAT(gltf_remarks(scene), HasSubstr("beside an emissive picture with one"));
}

Json translucent(const std::string& mode, double factor) {
  return {{"pbrMetallicRoughness",
           {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {1, 1, 1, factor}}}},
          {"alphaMode", mode},
          {"alphaCutoff", 0.4}};
}

TEST(GltfAlpha, BlendIsTheShareOfRaysAndMaskIsAllOrNothing) {
  const auto alpha = [](const std::string& mode) {
    const SceneDescription scene = textured(translucent(mode, 0.9), kFour).scene();
    std::vector<double> values;
    for (const Vec2 uv : {Vec2{0.25, 0.75}, {0.75, 0.75}, {0.25, 0.25}})
      values.push_back(scene.textures(scene.shapes.at(0).alpha, {.uv = uv}));
    return values;
  };
  const auto blend = alpha("BLEND"), mask = alpha("MASK"), opaque = alpha("OPAQUE");
  // Alpha of the picture: 255, 0 and 128.
  EXPECT_NEAR(blend[0], 0.9, 1e-6);
  EXPECT_NEAR(blend[1], 0, 1e-6);
  EXPECT_NEAR(blend[2], 0.9 * 128 / 255, 1e-6);
  EXPECT_EQ(mask, (std::vector<double>{1, 0, 1}));
  EXPECT_EQ(opaque, (std::vector<double>{1, 1, 1}));
}

TEST(GltfAlpha, FactorsNeedNoTexture) {
  const auto alpha = [](const std::string& mode, double factor) {
    Json material = translucent(mode, factor);
    material["pbrMetallicRoughness"].erase("baseColorTexture");
    return surfaced(material).scene().shapes.at(0).alpha.constant;
  };
  EXPECT_EQ(alpha("BLEND", 0.25), 0.25);
  EXPECT_EQ(alpha("MASK", 0.25), 0);
  EXPECT_EQ(alpha("MASK", 0.5), 1);
  EXPECT_EQ(alpha("OPAQUE", 0.25), 1);
}

TEST(GltfMaterials, WhatIsLeftOutIsReported) {
  const Json material = {
      {"occlusionTexture", {{"index", 0}}},
      {"extensions",
       {{"KHR_materials_unlit", Json::object()},
        {"KHR_materials_clearcoat", {{"clearcoatNormalTexture", {{"index", 0}}}}},
        {"KHR_materials_anisotropy", {{"anisotropyTexture", {{"index", 0}}}}}}}};
  const SceneDescription scene = textured(material, kFour).scene();
  const std::string remarks = gltf_remarks(scene);
  EXPECT_THAT(remarks, HasSubstr("scene.gltf#/materials/0/occlusionTexture: occlusionTexture is "
                                 "not applied -> the light is computed"));
  EXPECT_THAT(remarks, HasSubstr("clearcoatNormalTexture is not applied"));
  EXPECT_THAT(remarks, HasSubstr("anisotropyTexture is not applied"));
  EXPECT_THAT(remarks, HasSubstr("a surface that is not lit -> diffuse, with its base colour"));
  EXPECT_NE(material_of(scene).plain_diffuse(), nullptr);
}

TEST(GltfMaterials, BadValuesNameTheirPlace) {
  const auto error = [](const Json& material) { return textured(material, kFour).error(); };
  EXPECT_EQ(error(with("KHR_materials_ior", {{"ior", 0.5}})),
            "scene.gltf#/materials/0/extensions/KHR_materials_ior/ior: found 0.5, allowed: 0, or 1 "
            "or more");
  EXPECT_EQ(error(with("KHR_materials_clearcoat", {{"clearcoatFactor", 1.5}})),
            "scene.gltf#/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor: found "
            "1.5, allowed: a number from 0 to 1");
  EXPECT_EQ(error({{"normalTexture", {{"index", 7}}}}),
            "scene.gltf#/materials/0/normalTexture/index: found 7, allowed: the index of a "
            "texture, 0 to 0");
  EXPECT_EQ(error({{"normalTexture", {{"index", 0}, {"scale", nullptr}}}}),
            "scene.gltf#/materials/0/normalTexture/scale: found null, allowed: a finite number");
  GltfFile file = surfaced({{"normalTexture", {{"index", 0}}}});
  file.json["images"] = Json::array({{{"uri", "missing.png"}}});
  EXPECT_THAT(file.error(), HasSubstr("scene.gltf#/images/0/uri: "));
}

}  // namespace
}  // namespace lucerna
