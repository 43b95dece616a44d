// Each number of a scene file and of an edit, at the ends of its range.  Either the load is refused
// with the place and the value, or no answer about the scene holds NaN, an infinity or a negative
// number.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "tests/server/extremes/wire_answers.h"
#include "tests/server/extremes/wire_queries.h"
#include "tests/temp_directory.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kExtremes[] = {"1e300", "1e-300", "1.7e308", "-1",     "1e150", "1e-150",
                                     "1e38",  "1e-38",  "1e-45",   "1e-310", "0"};

/// A number of a .pbrt file: @ in the text that follows WorldBegin, or precedes it.
struct PlaceInFile {
  const char* before;
  const char* after;
};

const std::vector<PlaceInFile>& places() {
  static const std::vector<PlaceInFile> places{
      {"Film \"rgb\" \"float iso\" @", ""},
      {"Camera \"perspective\" \"float shutterclose\" @", ""},
      {"Camera \"perspective\" \"float shutteropen\" @ \"float shutterclose\" 2e300", ""},
      {"Camera \"perspective\" \"float shutterclose\" @ Film \"rgb\" \"float iso\" @", ""},
      {"Camera \"perspective\" \"float fov\" @", ""},
      {"Camera \"perspective\" \"float lensradius\" @", ""},
      {"Camera \"perspective\" \"float lensradius\" 0.1 \"float focaldistance\" @", ""},
      {"Camera \"perspective\" \"float frameaspectratio\" @", ""},
      {"Camera \"orthographic\" \"float screenwindow\" [-1 @ -1 1]", ""},
      {"Film \"rgb\" \"float cropwindow\" [0 @ 0 1]", ""},
      {"PixelFilter \"gaussian\" \"float sigma\" @", ""},
      {"PixelFilter \"gaussian\" \"float xradius\" @", ""},
      {"PixelFilter \"mitchell\" \"float B\" @", ""},
      {"PixelFilter \"sinc\" \"float tau\" @", ""},
      {"Translate @ 0 0 Camera \"perspective\"", ""},
      {"Scale 1 1 @ Camera \"perspective\"", ""},
      {"LookAt @ 0 0 0 0 1 0 1 0", ""},
      {"TransformTimes 0 @ ActiveTransform EndTime Translate 1 0 0 ActiveTransform All", ""},
      {"ActiveTransform EndTime Translate @ 0 0 ActiveTransform All", ""},
      {"TransformTimes 0 @ Camera \"perspective\" \"float shutterclose\" 1e5",
       "ActiveTransform EndTime Translate 1 0 0 AreaLightSource \"diffuse\" Shape \"sphere\""},
      {"", "LightSource \"point\" \"rgb I\" [@ 1 1]"},
      {"", "LightSource \"point\" \"float scale\" @"},
      {"", "LightSource \"point\" \"float power\" @"},
      {"", "LightSource \"point\" \"blackbody I\" @"},
      {"", "LightSource \"point\" \"spectrum I\" [400 1 500 @ 600 1]"},
      {"", "LightSource \"point\" \"spectrum I\" [400 @ 500 1]"},
      {"", "LightSource \"point\" \"point3 from\" [@ 0 1]"},
      {"", "LightSource \"spot\" \"float coneangle\" @"},
      {"", "LightSource \"spot\" \"float coneangle\" 90 \"float conedeltaangle\" @"},
      {"", "LightSource \"spot\" \"point3 to\" [@ 0 -1]"},
      {"", "LightSource \"spot\" \"float scale\" @ \"float power\" 1e30"},
      {"", "Scale 1 2 @ LightSource \"spot\""},
      {"", "Scale 1 2 @ LightSource \"spot\" \"float scale\" @"},
      {"", "ConcatTransform [1 @ 0 0 0 1 0 0 0 0 1 0 0 0 0 1] LightSource \"spot\""},
      {"", "LightSource \"distant\" \"float illuminance\" @"},
      {"", "LightSource \"distant\" \"float angulardiameter\" @"},
      {"", "LightSource \"distant\" \"rgb L\" [1 @ 1] \"point3 from\" [@ 1 1]"},
      {"", "LightSource \"infinite\" \"rgb L\" [1 1 @]"},
      {"", "LightSource \"infinite\" \"float illuminance\" @"},
      {"", "LightSource \"infinite\" \"point3 portal\" [@ 0 3 0 0 3 0 1 3 @ 1 3]"},
      {"", "LightSource \"projection\" \"float fov\" @"},
      {"", "LightSource \"projection\" \"float power\" @"},
      {"", "LightSource \"projection\" \"string projection\" \"orthographic\" \"float extent\" @"},
      {"", "LightSource \"goniometric\" \"float scale\" @ \"rgb I\" [@ 1 1]"},
      {"", "AreaLightSource \"diffuse\" \"rgb L\" [@ 1 1] Shape \"sphere\""},
      {"", "AreaLightSource \"diffuse\" \"float scale\" @ Shape \"disk\""},
      {"", "AreaLightSource \"diffuse\" \"float power\" @ Shape \"cylinder\""},
      {"", "AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" @"},
      {"", "AreaLightSource \"diffuse\" \"float power\" 5 Shape \"sphere\" \"float radius\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"sphere\" \"float zmin\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"sphere\" \"float zmax\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"sphere\" \"float phimax\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" @ \"float alpha\" 0"},
      {"", "AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"disk\" \"float radius\" @"},
      {"",
       "AreaLightSource \"diffuse\" Shape \"disk\" \"float radius\" 1e20 \"float innerradius\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"disk\" \"float height\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"disk\" \"float phimax\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"cylinder\" \"float radius\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"cylinder\" \"float zmin\" @"},
      {"", "AreaLightSource \"diffuse\" Shape \"cylinder\" \"float zmax\" @ \"float phimax\" @"},
      {"", "AreaLightSource \"diffuse\" Scale @ @ @ Shape \"sphere\""},
      {"", "AreaLightSource \"diffuse\" Scale 1 1 @ Shape \"disk\""},
      {"", "AreaLightSource \"diffuse\" Translate 0 @ 0 Shape \"cylinder\""},
      {"", "AreaLightSource \"diffuse\" Rotate @ 1 0 1 Shape \"disk\""},
      {"", "AreaLightSource \"diffuse\" Scale @ 1 1 Shape \"trianglemesh\" SQUARE"},
      {"", "AreaLightSource \"diffuse\" Scale @ @ @ Shape \"trianglemesh\" SQUARE"},
      {"",
       "AreaLightSource \"diffuse\" Scale @ @ @ Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 "
       "0 1 0 1 1 1]"},
      {"", "Scale @ @ @ Shape \"sphere\""},
      {"", "Shape \"sphere\" \"float radius\" @"},
      {"", "Shape \"curve\" \"float width\" @ \"point3 P\" [0 0 0 1 0 1 2 0 0 3 0 1]"},
      {"", "Shape \"trianglemesh\" \"point3 P\" [0 0 @ 1 0 0 0 1 0]"},
      {"", "Material \"conductor\" \"float roughness\" @ Shape \"sphere\""},
      {"", "Material \"conductor\" \"rgb eta\" [@ 1 1] \"rgb k\" [1 @ 1] Shape \"sphere\""},
      {"", "Material \"dielectric\" \"float eta\" @ Shape \"sphere\""},
      {"", "Material \"dielectric\" \"float roughness\" @ Shape \"sphere\""},
      {"", "Material \"coateddiffuse\" \"float thickness\" @ Shape \"sphere\""},
      {"", "Material \"diffuse\" \"rgb reflectance\" [@ 1 1] Shape \"sphere\""},
      {"", "Material \"diffusetransmission\" \"float scale\" @ Shape \"sphere\""},
      {"",
       "Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" @ Material \"diffuse\" "
       "\"texture reflectance\" \"t\" Shape \"sphere\""},
      {"",
       "Texture \"t\" \"float\" \"constant\" \"float value\" @ Material \"conductor\" \"texture "
       "roughness\" \"t\" Shape \"sphere\""},
      {"",
       "Texture \"t\" \"float\" \"checkerboard\" \"float tex1\" @ Material \"diffuse\" \"texture "
       "displacement\" \"t\" Shape \"sphere\""},
      {"", "Shape \"sphere\" \"float alpha\" @"},
  };
  return places;
}

/// What precedes WorldBegin, with a film of a few pixels.
std::string with_film(std::string before) {
  const std::string film = "Film \"rgb\"";
  if (before.find(film) == std::string::npos) before += " " + film;
  return before.insert(before.find(film) + film.size(),
                       " \"integer xresolution\" 4 \"integer yresolution\" 4");
}

std::string filled(std::string text, const std::string& value) {
  for (std::size_t at; (at = text.find("SQUARE")) != std::string::npos;)
    text.replace(at, 6,
                 "\"point3 P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"integer indices\" [0 1 2 0 2 3]");
  for (std::size_t at; (at = text.find('@')) != std::string::npos;) text.replace(at, 1, value);
  return text;
}

/// Whether a shape lets a constant part of direct light pass.
bool has_sheet(const std::string& text) {
  static const std::string kAlpha = "\"float alpha\" ";
  const std::size_t at = text.find(kAlpha);
  if (at == std::string::npos) return false;
  const double alpha = std::strtod(text.c_str() + at + kAlpha.size(), nullptr);
  return std::isnormal(alpha) && alpha > 0 && alpha < 1;
}

class WireParameters : public ::testing::Test {
 protected:
  grpc::Status load(const std::string& text, std::string* id,
                    const std::string& name = "scene.pbrt") {
    std::ofstream(root_.path() / name) << text;
    v1::LoadSceneRequest q;
    q.set_path(name);
    v1::LoadSceneResponse r;
    const grpc::Status s = service_.call(q, &r);
    *id = r.scene_id();
    return s;
  }

  /// Sends every query about the scene, or all but those for pictures.
  void query(const std::string& id, bool with_pictures = true, bool has_panes = false) {
    constexpr int kBatch = 3;
    WireScene scene;
    scene.id = id;
    scene.has_panes = has_panes;
    WireQueries queries(service_, numbers_, scene, kBatch);
    for (const v1::Light& light : queries.lights()) queries.query_light(light);
    with_pictures ? queries.query_scene() : queries.query_points();
    for (const std::string& failure : queries.failures()) ADD_FAILURE() << failure;
    (void)service_.status(about<v1::ReleaseSceneRequest>(id));
  }

  TempDirectory root_;
  Service service_{scenes_in(root_.path())};
  ExtremeNumbers numbers_{20260202};
};

TEST_F(WireParameters, OfFilesAreRefusedOrAnsweredWithFiniteNumbers) {
  int refused = 0, answered = 0;
  for (const PlaceInFile& place : places())
    for (const char* value : kExtremes) {
      // A floor and a lamp, so that queries have something to meet.
      const std::string text = fmt::format(
          "{}\nWorldBegin\n"
          "AttributeBegin {}\nAttributeEnd\n"
          "Translate 0 0 -3 Shape \"disk\" \"float radius\" 5\nLightSource \"point\"\n",
          filled(with_film(place.before), value), filled(place.after, value));
      SCOPED_TRACE(text);
      std::string id;
      const grpc::Status s = load(text, &id);
      if (s.ok()) {
        ++answered;
        query(id, true, has_sheet(text));
      } else {
        ++refused;
        EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << s.error_message();
        EXPECT_THAT(s.error_message(), StartsWith("scene.pbrt:"));
      }
      if (HasFailure()) return;
    }
  EXPECT_GT(refused, 100);
  EXPECT_GT(answered, 100);
}

/// Parts of a glTF file with a number @: members of its node, of the light at the node, of its
/// material, and of its camera.
struct PlaceInGltf {
  const char *node = "", *light = "", *material = "", *camera = "";
};

constexpr PlaceInGltf kGltfPlaces[]{
    {.light = ", \"intensity\": @"},
    {.light = ", \"intensity\": @, \"color\": [@, 1, 1]"},
    {.light = ", \"color\": [1, @, 1]"},
    {.light = ", \"range\": @"},
    {.light = ", \"spot\": {\"outerConeAngle\": @}"},
    {.light = ", \"spot\": {\"innerConeAngle\": @}"},
    {.node = ", \"scale\": [@, 1, 1]"},
    {.node = ", \"scale\": [@, @, @]"},
    {.node = ", \"translation\": [0, @, 0]"},
    {.node = ", \"rotation\": [0, @, 0, 1]"},
    {.node = ", \"matrix\": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, @, 0, 0, 0, 0, 1]"},
    {.material = ", \"emissiveFactor\": [@, 1, 1]"},
    {.material = ", \"emissiveFactor\": [1, 1, 1], \"extensions\": "
                 "{\"KHR_materials_emissive_strength\": {\"emissiveStrength\": @}}"},
    {.material = ", \"emissiveFactor\": [1, 1, @], \"extensions\": "
                 "{\"KHR_materials_emissive_strength\": {\"emissiveStrength\": @}}"},
    {.material = ", \"extensions\": {\"KHR_materials_ior\": {\"ior\": @}}"},
    {.material = ", \"extensions\": {\"KHR_materials_specular\": {\"specularColorFactor\": [@, 1, "
                 "1]}}"},
    {.material = ", \"extensions\": {\"KHR_materials_anisotropy\": {\"anisotropyStrength\": 0.5, "
                 "\"anisotropyRotation\": @}}"},
    {.material = ", \"extensions\": {\"KHR_materials_pbrSpecularGlossiness\": "
                 "{\"glossinessFactor\": @}}"},
    {.material = ", \"pbrMetallicRoughness\": {\"roughnessFactor\": @}"},
    {.material = ", \"pbrMetallicRoughness\": {\"baseColorFactor\": [@, 1, 1, 1]}"},
    {.material = ", \"alphaMode\": \"MASK\", \"alphaCutoff\": @"},
    {.camera = "\"yfov\": @, \"znear\": 1"},
    {.camera = "\"yfov\": 1, \"znear\": @"},
    {.camera = "\"yfov\": 1, \"znear\": 1, \"aspectRatio\": @"},
};

TEST_F(WireParameters, OfGltfAreRefusedOrAnsweredWithFiniteNumbers) {
  // A triangle (0, 0, 0), (1, 0, 0), (0, 1, 0).
  const std::string kTriangle = "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
  for (const PlaceInGltf& place : kGltfPlaces)
    for (const char* value : kExtremes) {
      const std::string camera = *place.camera != 0 ? place.camera : "\"yfov\": 1, \"znear\": 1";
      const std::string light = *place.light != 0 ? place.light : "";
      const char* type = light.find("spot") != std::string::npos ? "spot" : "point";
      const std::string text = filled(
          fmt::format(
              R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0, 1]}}],
"nodes": [{{"mesh": 0, "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}{}}},
{{"camera": 0, "translation": [0, 0, 3]}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
"materials": [{{"doubleSided": true{}}}],
"cameras": [{{"type": "perspective", "perspective": {{{}}}}}],
"extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "{}"{}}}]}}}},
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 36}}],
"buffers": [{{"byteLength": 36, "uri": "{}"}}]}})",
              place.node, place.material, camera, type, light, kTriangle),
          value);
      SCOPED_TRACE(text);
      std::string id;
      const grpc::Status s = load(text, &id, "scene.gltf");
      if (s.ok()) {
        query(id, false);  // glTF has no small film
      } else {
        EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << s.error_message();
        EXPECT_THAT(s.error_message(), StartsWith("scene.gltf"));
      }
      if (HasFailure()) return;
    }
}

TEST_F(WireParameters, OfEditsAreRefusedOrAnsweredWithFiniteNumbers) {
  std::string id;
  ASSERT_TRUE(load(with_film("") +
                       "\nWorldBegin\nLightSource \"point\" \"rgb I\" [3e38 1 1]\n"
                       "AreaLightSource \"diffuse\" \"rgb L\" [3e38 3e38 1] Shape \"sphere\"\n",
                   &id)
                  .ok());
  using Set = std::function<void(v1::LightEdit*, double)>;
  const auto rgb = [](v1::Rgb* c, double v) { c->set_r(v), c->set_g(v), c->set_b(v); };
  const std::pair<const char*, Set> kFields[]{
      {"change.scale",
       [](auto* e, double v) {
         e->mutable_change()->set_light_id(1), e->mutable_change()->set_scale(v);
       }},
      {"change.scale of a surface",
       [](auto* e, double v) {
         e->mutable_change()->set_light_id(2), e->mutable_change()->set_scale(v);
       }},
      {"change.tint",
       [&](auto* e, double v) {
         e->mutable_change()->set_light_id(2);
         rgb(e->mutable_change()->mutable_tint(), v);
       }},
      {"change.placement",
       [](auto* e, double v) {
         e->mutable_change()->set_light_id(2);
         e->mutable_change()->mutable_placement()->mutable_shift_m()->set_x(v);
       }},
      {"put.point.intensity_cd",
       [&](auto* e, double v) {
         rgb(e->mutable_put()->mutable_point()->mutable_intensity_cd(), v);
       }},
      {"put.point.position_m",
       [](auto* e, double v) {
         e->mutable_put()->mutable_point()->mutable_position_m()->set_x(v);
       }},
      {"put.spot",
       [&](auto* e, double v) {
         v1::SpotLight* spot = e->mutable_put()->mutable_spot();
         rgb(spot->mutable_intensity_cd(), v);
         spot->mutable_axis()->set_z(1), spot->set_cone_half_angle_rad(1);
       }},
      {"put.spot.cone_half_angle_rad",
       [&](auto* e, double v) {
         v1::SpotLight* spot = e->mutable_put()->mutable_spot();
         rgb(spot->mutable_intensity_cd(), 1);
         spot->mutable_axis()->set_z(1), spot->set_cone_half_angle_rad(v);
       }},
      {"put.distant",
       [&](auto* e, double v) {
         rgb(e->mutable_put()->mutable_distant()->mutable_illuminance_lx(), v);
         e->mutable_put()->mutable_distant()->mutable_to_light()->set_z(1);
       }},
      {"put.sun",
       [&](auto* e, double v) {
         rgb(e->mutable_put()->mutable_sun()->mutable_illuminance_lx(), v);
         e->mutable_put()->mutable_sun()->mutable_to_light()->set_z(1);
         e->mutable_put()->mutable_sun()->set_angular_diameter_rad(0.01);
       }},
      {"put.sun.angular_diameter_rad",
       [&](auto* e, double v) {
         rgb(e->mutable_put()->mutable_sun()->mutable_illuminance_lx(), 3e38);
         e->mutable_put()->mutable_sun()->mutable_to_light()->set_z(1);
         e->mutable_put()->mutable_sun()->set_angular_diameter_rad(v);
       }},
      {"put.uniform_infinite",
       [&](auto* e, double v) {
         rgb(e->mutable_put()->mutable_uniform_infinite()->mutable_radiance_cd_m2(), v);
       }},
  };
  for (const auto& [name, set_field] : kFields)
    for (const double value : {1e300, 1e-300, 1.7e308, -1.0, 1e9, 1e38, 3e38, 1e-45, 0.0}) {
      SCOPED_TRACE(fmt::format("{} = {}", name, value));
      auto q = about<v1::EditLightsRequest>(id);
      set_field(q.add_edits(), value);
      v1::EditLightsResponse r;
      const grpc::Status s = service_.call(q, &r);
      if (s.ok()) {
        if (r.scene_id() != id) query(r.scene_id());
      } else {
        EXPECT_EQ(s.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << s.error_message();
        EXPECT_THAT(s.error_message(), HasSubstr("allowed"));
      }
      if (HasFailure()) return;
    }
}

}  // namespace
}  // namespace lucerna::testing
