#include <fstream>  // tinygltf needs it even without files
#define TINYGLTF_IMPLEMENTATION
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "lights/maths/stop_poll.h"
#include "server/gltf/model.h"

namespace lucerna::gltf {
namespace {

/// A copy without the members that the loader reads itself, or does not read.
Json core_of(const Json& value) {
  if (value.is_object()) {
    Json result = Json::object();
    for (const auto& [key, member] : value.items())
      if (key != "extensions" && key != "extras" && key != "min" && key != "max")
        result.emplace(key, core_of(member));
    return result;
  }
  if (value.is_array()) {
    Json result = Json::array();
    StopPoll poll;
    for (const Json& element : value) poll(), result.push_back(core_of(element));
    return result;
  }
  // tinygltf reads 3.0 as no integer.
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (number == std::floor(number) && std::abs(number) < 0x1p53)
      return static_cast<std::int64_t>(number);
  }
  return value;
}

tinygltf::Model parsed(const View& root, const Json& core) {
  const std::string text = core.dump();
  tinygltf::Model model;
  std::string error, warning;
  tinygltf::TinyGLTF reader;
  if (!reader.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                  static_cast<unsigned>(text.size()), "", 0))
    root.fail(fmt::format("tinygltf: {}", printable(error)));
  return model;
}

/// tinygltf cannot be stopped, so it gets some nodes at a time.
void read_nodes(const View& root, const Json& asset, std::vector<tinygltf::Node>& nodes) {
  const auto found = root.find("nodes");
  if (!found) return;
  constexpr std::size_t kAtOnce = 4096;
  const Json& all = found->json();
  nodes.reserve(all.size());
  for (std::size_t first = 0; first < all.size(); first += kAtOnce) {
    root.context().poll();
    Json some = {{"asset", asset}, {"nodes", Json::array()}};
    for (std::size_t i = first; i < std::min(first + kAtOnce, all.size()); ++i)
      some["nodes"].push_back(core_of(all[i]));
    std::ranges::move(parsed(root, some).nodes, std::back_inserter(nodes));
  }
}

}  // namespace

tinygltf::Model parse_model(const View& root) {
  constexpr const char* kParts[] = {"asset", "accessors", "bufferViews", "meshes",    "scenes",
                                    "scene", "cameras",   "skins",       "animations"};
  Json core = Json::object();
  for (const char* part : kParts)
    if (const auto found = root.find(part)) core[part] = core_of(found->json());
  if (core.contains("meshes")) {
    for (std::size_t m = 0; m < core["meshes"].size(); ++m) {
      for (std::size_t p = 0; p < core["meshes"][m]["primitives"].size(); ++p) {
        // tinygltf refuses indices without bytes.  Those of compressed meshes are not needed.
        const View given = root.at("meshes")[m].at("primitives")[p];
        const auto accessors = root.find("accessors");
        const auto indices = given.index("indices", accessors ? accessors->size() : 0, "accessor");
        if (given.extension("KHR_draco_mesh_compression"))
          core["meshes"][m]["primitives"][p].erase("indices");
        else if (indices && !(*accessors)[*indices].find("bufferView"))
          given.at("indices").fail(fmt::format(
              "names accessor {}, which has no bufferView, allowed: one with a bufferView",
              *indices));
      }
    }
  }
  tinygltf::Model model = parsed(root, core);
  read_nodes(root, core["asset"], model.nodes);
  return model;
}

}  // namespace lucerna::gltf
