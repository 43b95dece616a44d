// glTF scenes with other files: pictures, luminaires, environments; scenes in the store.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "gltf_fixture.h"
#include "lights/pictures/sphere_map.h"
#include "server/pbrt/load_pbrt.h"
#include "server/queries/receiver_irradiance.h"
#include "server/scene/scene.h"
#include "server/store/scene_store.h"

namespace lucerna {
namespace {

using testing::bytes_of;
using ::testing::ElementsAre;
using testing::gltf_remarks;
using testing::GltfFile;
using testing::GltfFiles;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Json;
using testing::message_of;
using testing::png;
using ::testing::StartsWith;
using Point = Vec3;

/// A triangle that shows a picture, with these (u, v) at its corners.
GltfFile painted(const std::vector<float>& uv, const Json& texture_info = Json::object()) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["attributes"]["TEXCOORD_0"] = file.add_floats(uv, "VEC2");
  primitive["material"] = 0;
  Json info = {{"index", 0}};
  info.update(texture_info);
  file.json["materials"] = Json::array(
      {{{"emissiveFactor", {1, 1, 1}},
        {"emissiveTexture", info},
        {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 50}}}}}}});
  file.json["textures"] = Json::array({{{"source", 0}}});
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  return file;
}

// White above, black below.
const std::string kPicture = png(1, 2, {255, 255, 255, 255, 0, 0, 0, 255});

TEST(GltfPictures, AnEmbeddedPictureShinesFromItsTop) {
  GltfFile file = painted({0, 0, 0.25, 0, 0, 1});
  file.json["images"] =
      Json::array({{{"bufferView", file.add_view(kPicture)}, {"mimeType", "image/png"}}});
  const SceneDescription scene = file.scene();
  const auto& emission = scene.shapes.at(0).emission;
  ASSERT_TRUE(emission && emission->picture);
  EXPECT_EQ(emission->radiance_cd_m2, Rgb(50.0));
  // v = 0 of the file is the top of the picture, which is v = 1 here.
  const auto& uv = testing::mesh_of(scene.shapes[0]).corner_uv;
  EXPECT_THAT(uv, ElementsAre(Vec2f{0, 1}, Vec2f{0.25F, 1}, Vec2f{0, 0}));
  EXPECT_EQ(emission->picture->at({0, 1}), Rgb(1.0));
  EXPECT_EQ(emission->picture->at({0, 0}), Rgb(0.0));
  EXPECT_EQ(emission->picture->name, "scene.gltf#/images/0");
}

TEST(GltfPictures, RepetitionsAreMovedToTheFirst) {
  GltfFile file = painted({3, -2, 3.5, -2, 3, -1});
  file.json["images"] =
      Json::array({{{"bufferView", file.add_view(kPicture)}, {"mimeType", "image/png"}}});
  SceneDescription scene = file.scene();
  EXPECT_THAT(testing::mesh_of(scene.shapes.at(0)).corner_uv,
              ElementsAre(Vec2f{0, 1}, Vec2f{0.5F, 1}, Vec2f{0, 0}));
  EXPECT_THAT(gltf_remarks(scene), Not(HasSubstr("repeats")));
  file.json["materials"][0]["emissiveTexture"]["extensions"]["KHR_texture_transform"] = {
      {"scale", {4, 1}}};
  EXPECT_THAT(gltf_remarks(file.scene()),
              HasSubstr("an emissive picture that repeats within a triangle is not modelled"));
}

// The specification's matrices, multiplied by hand: u becomes 0.25 + 0.5 v and v becomes
// 0.75 - 0.5 u, where v runs downwards.
TEST(GltfPictures, TextureTransforms) {
  GltfFile file = painted({0, 0, 1, 0, 0, 1}, {{"extensions",
                                                {{"KHR_texture_transform",
                                                  {{"offset", {0.25, 0.75}},
                                                   {"rotation", std::numbers::pi / 2},
                                                   {"scale", {0.5, 0.5}}}}}}});
  file.json["images"] =
      Json::array({{{"bufferView", file.add_view(kPicture)}, {"mimeType", "image/png"}}});
  file.json["samplers"] = Json::array({{{"wrapS", 33071}, {"wrapT", 33071}}});
  file.json["textures"][0]["sampler"] = 0;
  const SceneDescription scene = file.scene();
  const auto& uv = testing::mesh_of(scene.shapes.at(0)).corner_uv;
  const Vec2f expected[] = {{0.25F, 0.25F}, {0.25F, 0.75F}, {0.75F, 0.25F}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(uv[i].x, expected[i].x, 1e-6) << i;
    EXPECT_NEAR(uv[i].y, expected[i].y, 1e-6) << i;
  }
}

constexpr char kIes[] =
    "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 5 1 2 0 0 0\n1 1 50\n0 45 90\n0 90 180 270 360\n"
    "200 100 10\n200 100 20\n200 100 30\n200 100 40\n200 100 10\n";

TEST(GltfLuminaires, ShineAlongMinusZ) {
  GltfFile file;
  file.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array({{{"uri", "lamp.ies"}}});
  file.add_node(
      {{"translation", {1, 2, 3}},
       {"extensions",
        {{"EXT_lights_ies", {{"light", 0}, {"multiplier", 2}, {"color", {1, 0.5, 0.5}}}}}}});
  const GltfFiles files;
  files.write("scene.gltf", file.text());
  files.write("lamp.ies", kIes);
  const auto scene = testing::value_of(files.load("scene.gltf"));
  const auto& light = std::get<GoniometricLightParams>(scene.lights.at(0).params);
  EXPECT_EQ(light.position_m, Point(1, 2, 3));
  EXPECT_EQ(light.intensity, Rgb(2, 1, 1));
  const GoniometricIntensity intensity(light);
  EXPECT_NEAR(intensity.intensity({0, 0, -1}).r, 2 * 200, 1e-9);
  // The horizontal angle 0 is +x, and 90 degrees are +y: counter-clockwise seen from behind the
  // light, which is above a luminaire that hangs.
  EXPECT_NEAR(intensity.intensity({1, 0, 0}).r, 2 * 10, 1e-9);
  EXPECT_NEAR(intensity.intensity({0, 1, 0}).r, 2 * 20, 1e-9);
  EXPECT_NEAR(intensity.intensity({-1, 0, 0}).r, 2 * 30, 1e-9);
  EXPECT_NEAR(intensity.intensity({0, 0, 1}).r, 0, 1e-9);
}

// The zero of both angles is -z for every type.  In the extension the plane x-z has the vertical
// angles, and horizontal angles of types A and B are clockwise: H = 90 is -y.
TEST(GltfLuminaires, TypesAAndBHaveTheirAnglesAboutMinusZ) {
  // All V at H = -90, 0, 90.  The values of a pole agree: of type B H = +-90, of type A V = +-90.
  const std::pair<const char*, const char*> kTypes[] = {{"2", "3 3 3\n1 9 5\n7 7 7\n"},
                                                        {"3", "1 3 5\n1 9 5\n1 7 5\n"}};
  for (const auto& [type, candela] : kTypes) {
    GltfFile file;
    file.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array({{{"uri", "lamp.ies"}}});
    file.add_node({{"extensions", {{"EXT_lights_ies", {{"light", 0}}}}}});
    const GltfFiles files;
    files.write("scene.gltf", file.text());
    files.write("lamp.ies", std::string("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 3 ") + type +
                                " 2 0 0 0\n1 1 50\n-90 0 90\n-90 0 90\n" + candela);
    const auto scene = testing::value_of(files.load("scene.gltf"));
    const GoniometricIntensity light(std::get<GoniometricLightParams>(scene.lights.at(0).params));
    const auto at = [&](double x, double y) { return light.intensity({x, y, -1e-9}).r; };
    EXPECT_NEAR(light.intensity({0, 0, -1}).r, 9, 1e-6);
    EXPECT_NEAR(at(1, 0), 5, 1e-6) << "V = 90, type " << type;
    EXPECT_NEAR(at(-1, 0), 1, 1e-6) << "V = -90, type " << type;
    EXPECT_NEAR(at(0, -1), 7, 1e-6) << "H = 90, type " << type;
    EXPECT_NEAR(at(0, 1), 3, 1e-6) << "H = -90, type " << type;
    EXPECT_EQ(light.intensity({0, 0, 1}).r, 0);
  }
}

TEST(GltfLuminaires, ErrorsNameTheFileAndItsLine) {
  GltfFile file;
  file.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array({{{"uri", "lamp.ies"}}});
  file.add_node({{"extensions", {{"EXT_lights_ies", {{"light", 0}}}}}});
  const GltfFiles files;
  files.write("scene.gltf", file.text());
  files.write("lamp.ies", "IESNA:LM-63-2002\nTILT=NONE\nx\n");
  EXPECT_THAT(message_of(files.load("scene.gltf").status()),
              StartsWith("scene.gltf#/extensions/EXT_lights_ies/lights/0: lamp.ies:3"));
}

/// A scene with a sky of six faces of one texel each.
std::string environment(GltfFile& file, const GltfFiles& files, std::uint8_t alpha) {
  // +x red, -x green, +y blue, -y black, +z white, -z black.
  const std::vector<std::vector<std::uint8_t>> colours{{255, 0, 0}, {0, 255, 0},     {0, 0, 255},
                                                       {0, 0, 0},   {255, 255, 255}, {0, 0, 0}};
  Json level = Json::array();
  for (std::size_t f = 0; f < 6; ++f) {
    std::vector<std::uint8_t> texel = colours[f];
    texel.push_back(alpha);
    files.write("face" + std::to_string(f) + ".png", png(1, 1, texel));
    file.json["images"].push_back({{"uri", "face" + std::to_string(f) + ".png"}});
    level.push_back(f);
  }
  file.json["extensions"]["EXT_lights_image_based"]["lights"] =
      Json::array({{{"intensity", 10},
                    {"specularImageSize", 1},
                    {"specularImages", Json::array({level})},
                    {"irradianceCoefficients", Json::array()}}});
  file.json["scenes"] =
      Json::array({{{"extensions", {{"EXT_lights_image_based", {{"light", 0}}}}}}});
  return file.text();
}

TEST(GltfEnvironments, FacesPointAlongTheirAxes) {
  GltfFile file;
  const GltfFiles files;
  files.write("scene.gltf", environment(file, files, 255));
  const auto scene = testing::value_of(files.load("scene.gltf"));
  const auto& sky = std::get<ImageInfiniteLightParams>(scene.lights.at(0).params);
  EXPECT_EQ(sky.radiance_cd_m2, Rgb(10.0));
  const auto at = [&](const Point& w) {
    return sky.map->lookup(MapAxes(sky.world_from_map).map_from_world(w));
  };
  EXPECT_EQ(at({1, 0, 0}), Rgb(1, 0, 0));
  EXPECT_EQ(at({-1, 0, 0}), Rgb(0, 1, 0));
  EXPECT_EQ(at({0, 1, 0}), Rgb(0, 0, 1));
  EXPECT_EQ(at({0, 0, 1}), Rgb(1, 1, 1));
  EXPECT_EQ(at({0, 0, -1}), Rgb(0, 0, 0));
}

TEST(GltfEnvironments, AlphaDividesTheColour) {
  GltfFile file;
  const GltfFiles files;
  files.write("scene.gltf", environment(file, files, 51));  // a fifth
  const auto scene = testing::value_of(files.load("scene.gltf"));
  const auto& sky = std::get<ImageInfiniteLightParams>(scene.lights.at(0).params);
  EXPECT_NEAR(sky.map->brightest().r, 5, 1e-6);
  EXPECT_THAT(gltf_remarks(scene), Not(HasSubstr("alpha")));
}

TEST(GltfEnvironments, NegativeTexelsAreReported) {
  GltfFile file;
  const GltfFiles files;
  environment(file, files, 255);
  file.json["images"][5]["uri"] = "face5.pfm";
  files.write("face5.pfm", "PF\n1 1\n-1.0\n" + testing::bytes_of(std::vector<float>{1, -2, 3}));
  files.write("scene.gltf", file.text());
  const auto scene = testing::value_of(files.load("scene.gltf"));
  EXPECT_THAT(gltf_remarks(scene), HasSubstr("1 texel with a value below 0"));
}

// A picture of two texels across: each face is upright and not mirrored from the inside.
TEST(GltfEnvironments, FacesAreNotMirrored) {
  GltfFile file;
  const GltfFiles files;
  environment(file, files, 255);
  // Towards -z, red on the left (-x), blue on the right (+x); above bright, below dark.
  files.write("face5.png", png(2, 2, {255, 0, 0, 255, 0, 0, 255, 255, 0, 0, 0, 255, 0, 0, 0, 255}));
  for (int f = 0; f < 5; ++f)
    files.write("face" + std::to_string(f) + ".png", png(2, 2, std::vector<std::uint8_t>(16, 0)));
  file.json["extensions"]["EXT_lights_image_based"]["lights"][0]["specularImageSize"] = 2;
  files.write("scene.gltf", file.text());
  const auto scene = testing::value_of(files.load("scene.gltf"));
  const auto& sky = std::get<ImageInfiniteLightParams>(scene.lights.at(0).params);
  const auto at = [&](const Point& w) { return sky.map->lookup(normalized(w)); };
  EXPECT_GT(at({-0.5, 0.5, -1}).r, 0.9);
  EXPECT_GT(at({0.5, 0.5, -1}).b, 0.9);
  EXPECT_LT(luminance(at({0.5, -0.5, -1})), 0.1);
}

TEST(GltfEnvironments, SizesMustAgree) {
  GltfFile file;
  const GltfFiles files;
  environment(file, files, 255);
  file.json["extensions"]["EXT_lights_image_based"]["lights"][0]["specularImageSize"] = 4;
  files.write("scene.gltf", file.text());
  EXPECT_EQ(
      message_of(files.load("scene.gltf").status()),
      "scene.gltf#/extensions/EXT_lights_image_based/lights/0/specularImages/0/0: a picture of "
      "1 x 1 texels, allowed: 4 x 4, as specularImageSize says");
}

/// A room: a floor, a lamp of two triangles that shines down, a point, a spot and a distant light.
GltfFile room() {
  GltfFile file;
  const auto quad = [&](const std::vector<float>& corners, int material) {
    return Json{{"attributes", {{"POSITION", file.add_floats(corners, "VEC3")}}},
                {"indices", file.add(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3}, "SCALAR", 5123)},
                {"material", material}};
  };
  const Json grey = {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"metallicFactor", 0}};
  const Json diffuse = {{"KHR_materials_specular", {{"specularFactor", 0}}}};
  Json shining = diffuse;
  shining["KHR_materials_emissive_strength"] = {{"emissiveStrength", 800}};
  file.json["materials"] = Json::array({{{"pbrMetallicRoughness", grey}, {"extensions", diffuse}},
                                        {{"pbrMetallicRoughness", grey},
                                         {"emissiveFactor", {1, 0.5, 0.25}},
                                         {"extensions", shining}}});
  file.add_node({{"mesh", file.add_mesh(quad({-3, 0, 3, 3, 0, 3, 3, 0, -3, -3, 0, -3}, 0))}});
  file.add_node(
      {{"mesh", file.add_mesh(quad({-0.5, 0, -0.5, 0.5, 0, -0.5, 0.5, 0, 0.5, -0.5, 0, 0.5}, 1))},
       {"translation", {0, 2, 0}}});
  const auto light = [&](const Json& params, const Json& place) {
    Json node = GltfFile::light_node(file.add_light(params));
    node.update(place);
    file.add_node(node);
  };
  constexpr double h = std::numbers::sqrt2 / 2;
  light({{"type", "point"}, {"intensity", 40}, {"color", {1, 0.5, 0.25}}},
        {{"translation", {1, 1.5, 0}}});
  light({{"type", "directional"}, {"intensity", 300}}, {{"rotation", {-h, 0, 0, h}}});
  light({{"type", "spot"},
         {"intensity", 90},
         {"spot",
          {{"innerConeAngle", std::numbers::pi / 6}, {"outerConeAngle", std::numbers::pi / 3}}}},
        {{"translation", {-1, 1, 0}}, {"rotation", {-h, 0, 0, h}}});
  return file;
}

constexpr char kRoom[] = R"(WorldBegin
Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
Shape "trianglemesh" "point3 P" [-3 0 3 3 0 3 3 0 -3 -3 0 -3] "integer indices" [0 1 2 0 2 3]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [800 400 200]
Shape "trianglemesh" "point3 P" [-0.5 2 -0.5 0.5 2 -0.5 0.5 2 0.5 -0.5 2 0.5]
  "integer indices" [0 1 2 0 2 3]
AttributeEnd
LightSource "point" "rgb I" [40 20 10] "point3 from" [1 1.5 0]
LightSource "distant" "rgb L" [300 300 300] "point3 from" [0 1 0] "point3 to" [0 0 0]
LightSource "spot" "rgb I" [90 90 90] "point3 from" [-1 1 0] "point3 to" [-1 0 0]
  "float coneangle" 60 "float conedeltaangle" 30 "string profile" "quadratic"
)";

std::vector<IrradianceEstimate> lux(SceneDescription description, std::uint32_t bounces) {
  const auto scene = Scene::build(std::move(description));
  EXPECT_TRUE(scene.ok()) << scene.status();
  std::vector<IrradiancePoint> points;
  for (const float x : {-1.0F, -0.2F, 0.9F})
    points.push_back({{x, 0, 0.1F}, {1e-6F, 1e-6F, 1e-6F}, {0, 1, 0}});
  return estimate_irradiance(
             **scene, points,
             {.seed = 1, .samples_per_block = 64, .block_count = 16, .bounces = bounces}, {})
      .points;
}

TEST(GltfRooms, HaveTheSameLuxAsInPbrt) {
  const GltfFiles files;
  files.write("room.pbrt", kRoom);
  auto reader = AssetReader::open(files.path().string());
  auto pbrt = testing::value_of(load_pbrt(*reader, "room.pbrt"));
  const SceneDescription gltf = room().scene();
  for (const std::uint32_t bounces : {0U, 2U}) {
    const auto expected = lux(pbrt, bounces), found = lux(gltf, bounces);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Rgb e(expected[i].irradiance_lx), f(found[i].irradiance_lx);
      EXPECT_GT(e.g, 100);
      EXPECT_NEAR(f.r, e.r, 1e-5 * e.r) << bounces;
      EXPECT_NEAR(f.g, e.g, 1e-5 * e.g) << bounces;
      EXPECT_NEAR(f.b, e.b, 1e-5 * e.b) << bounces;
    }
  }
}

// An uploaded scene asks for all its files at once.
TEST(GltfStore, AnUploadNamesAllMissingFiles) {
  const GltfFiles files;
  std::filesystem::create_directory(files.path() / "root");
  auto assets = AssetStore::open({.directory = (files.path() / "assets").string()}).value();
  auto store = SceneStore::open({.root = (files.path() / "root").string()}, assets.get()).value();
  GltfFile file = painted({0, 0, 1, 0, 0, 1});
  file.json["images"] = Json::array({{{"uri", "lamp.png"}}, {{"uri", "unused.png"}}});
  file.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array({{{"uri", "lamp.ies"}}});
  Manifest manifest{"room/scene.gltf", {}};
  const auto put = [&](const std::string& name, const std::string& bytes) {
    manifest.assets[name] = sha256(bytes);
    auto upload = assets->upload(sha256(bytes), bytes.size(), 0);
    ASSERT_TRUE(upload.ok() && upload->append(bytes).ok() && upload->finish().ok());
  };
  const auto missing = [&] {
    std::vector<std::string> names;
    const auto loaded = store->load(manifest, {});
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    if (loaded.ok())
      for (const MissingAsset& m : loaded->missing) names.push_back(m.name);
    return names;
  };
  put("room/scene.gltf", file.text("data.bin"));
  EXPECT_THAT(missing(), ElementsAre("room/data.bin", "room/lamp.png", "room/lamp.ies"));
  put("room/data.bin", file.bytes());
  put("room/lamp.png", kPicture);
  put("room/lamp.ies", kIes);
  EXPECT_THAT(missing(), IsEmpty());
}

TEST(GltfStore, NamesChooseTheLoader) {
  const GltfFiles files;
  const GltfFile file = room();
  files.write("a.gltf", file.text());
  files.write("b.glb", file.binary());
  files.write("c.GLB", file.binary());
  files.write("d.pbrt", "WorldBegin");
  files.write("bad.gltf", "{");
  auto store = SceneStore::open({.root = files.path().string()}, nullptr).value();
  EXPECT_THAT(store->available().paths, ElementsAre("a.gltf", "b.glb", "bad.gltf", "d.pbrt"));
  for (const char* name : {"a.gltf", "b.glb", "c.GLB", "d.pbrt"})
    EXPECT_TRUE(store->load(name, {}).ok()) << name;
  EXPECT_THAT(message_of(store->load("bad.gltf", {}).status()), StartsWith("bad.gltf:1:"));
  EXPECT_EQ(store->size(), 4U);
}

}  // namespace
}  // namespace lucerna
