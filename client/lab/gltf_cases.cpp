#include "client/lab/gltf_cases.h"

#include <absl/strings/escaping.h>
#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace lucerna::conformance {
namespace {

using Json = nlohmann::ordered_json;

/// A quadrilateral that faces +z, in two triangles, as floats and as 16-bit indices.
constexpr float kCorners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
constexpr std::uint16_t kIndices[] = {0, 1, 2, 0, 2, 3};

std::string buffer() {
  std::string bytes(sizeof kCorners + sizeof kIndices, '\0');
  std::memcpy(bytes.data(), kCorners, sizeof kCorners);
  std::memcpy(bytes.data() + sizeof kCorners, kIndices, sizeof kIndices);
  return bytes;
}

/// A scene with a floor and the node `light`.
Case gltf(std::string name, std::string about, const Json& light, const Json& more) {
  const std::string bytes = buffer();
  // Above the light, looking down.
  const Json camera = {{"name", "camera"}, {"camera", 0}, {"translation", {0, 0, 6}}};
  Json scene = {
      {"asset", {{"version", "2.0"}, {"generator", "lucerna conformance"}}},
      {"scene", 0},
      {"scenes", {{{"name", name + ": " + about}, {"nodes", {0, 1, 2}}}}},
      {"nodes", {{{"name", "floor"}, {"mesh", 0}, {"scale", {4, 4, 1}}}, light, camera}},
      {"cameras",
       Json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}})},
      {"materials", Json::array({{{"name", "matt"}}})},
      {"meshes", Json::array({{{"primitives", Json::array({{{"attributes", {{"POSITION", 0}}},
                                                            {"indices", 1},
                                                            {"material", 0}}})}}})},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", 4},
         {"type", "VEC3"},
         {"min", {-1, -1, 0}},
         {"max", {1, 1, 0}}},
        {{"bufferView", 1}, {"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}}}},
      {"bufferViews",
       {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", sizeof kCorners}, {"target", 34962}},
        {{"buffer", 0},
         {"byteOffset", sizeof kCorners},
         {"byteLength", sizeof kIndices},
         {"target", 34963}}}},
      {"buffers", Json::array({{{"byteLength", bytes.size()},
                                {"uri", "data:application/octet-stream;base64," +
                                            absl::Base64Escape(bytes)}}})}};
  scene.merge_patch(more);
  return {.name = std::move(name),
          .about = std::move(about),
          .scene = {"scene.gltf", scene.dump(1) + "\n"}};
}

/// A light of KHR_lights_punctual, which shines along -z of its node.
Case punctual(std::string name, std::string about, const Json& light, Json node) {
  node["extensions"]["KHR_lights_punctual"]["light"] = 0;
  const Json more = {{"extensionsUsed", {"KHR_lights_punctual"}},
                     {"extensions", {{"KHR_lights_punctual", {{"lights", Json::array({light})}}}}}};
  return gltf(std::move(name), std::move(about), node, more);
}

}  // namespace

std::vector<Case> gltf_cases() {
  std::vector<Case> all;
  const Json above = {{"name", "light"}, {"translation", {0.25, -0.25, 3}}};
  all.push_back(punctual("gltf_point", "a point light in glTF",
                         {{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 12}}, above));
  all.push_back(punctual("gltf_spot", "a spot in glTF",
                         {{"type", "spot"},
                          {"intensity", 40},
                          {"spot", {{"innerConeAngle", 0.4}, {"outerConeAngle", 0.7}}}},
                         above));
  Json tilted = above;
  // 30 degrees about x.
  tilted["rotation"] = {0.25881904510252074, 0, 0, 0.9659258262890683};
  all.push_back(punctual("gltf_directional", "a directional light in glTF",
                         {{"type", "directional"}, {"color", {1, 1, 0.5}}, {"intensity", 3}},
                         tilted));
  const Json mesh = {{"name", "light"},
                     {"mesh", 1},
                     {"translation", {0.25, -0.25, 3}},
                     {"rotation", {1, 0, 0, 0}},
                     {"scale", {0.5, 0.25, 1}}};
  const Json more = {
      {"extensionsUsed", {"KHR_materials_emissive_strength"}},
      {"materials",
       {{{"name", "matt"}},
        {{"name", "light"},
         {"emissiveFactor", {1, 0.5, 0.25}},
         {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 10}}}}}}}},
      {"meshes",
       {{{"primitives",
          Json::array({{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"material", 0}}})}},
        {{"primitives",
          Json::array({{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"material", 1}}})}}}}};
  all.push_back(gltf("gltf_emissive", "a mesh that emits light in glTF", mesh, more));
  return all;
}

}  // namespace lucerna::conformance
