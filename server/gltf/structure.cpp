#include "server/gltf/structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "lights/maths/stop_poll.h"
#include "server/gltf/gltf_materials.h"

namespace lucerna::gltf {
namespace {

/// Accessors hold at most this many elements, so that vertices have 32-bit indices.
constexpr std::uint64_t kMostElements = 0xffff'ffff;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40;
/// tinygltf holds these offsets in an int.
constexpr std::uint64_t kMostSparseOffset = 0x7fff'ffff;
/// Quaternions of eight-bit numbers differ that much from unit length.
constexpr double kLengthTolerance = 0.01;

/// The number of elements of the array `key`; 0 if it is missing.
std::size_t count_of(const View& root, std::string_view key) {
  const auto found = root.find(key);
  return found ? found->require_array().size() : 0;
}

template <typename F>
void for_each(const View& parent, std::string_view key, F&& check) {
  const auto array = parent.find(key);
  if (!array) return;
  array->require_array();
  StopPoll poll;
  for (std::size_t i = 0; i < array->size(); ++i, poll()) {
    parent.context().poll();
    check((*array)[i]);
  }
}

void check_one_of(const View& value, std::initializer_list<std::string_view> allowed) {
  if (std::find(allowed.begin(), allowed.end(), value.text()) == allowed.end())
    value.fail(fmt::format("found \"{}\", allowed: {}", printable(value.text()),
                           fmt::join(allowed, ", ")));
}

void check_numbers(const View& parent, std::string_view key) {
  for_each(parent, key, [](const View& number) { number.number(); });
}

void check_component_type(const View& value, bool is_index) {
  const std::uint64_t type = value.integer(0, 1 << 16);
  const bool is_unsigned = type == 5121 || type == 5123 || type == 5125;
  if (is_unsigned || (!is_index && (type == 5120 || type == 5122 || type == 5126))) return;
  value.fail(fmt::format("found {}, allowed: {}", type,
                         is_index ? "5121, 5123, 5125" : "5120 to 5123, 5125, 5126"));
}

void check_accessor(const View& accessor, std::size_t views) {
  accessor.require_object();
  accessor.index("bufferView", views, "bufferView");
  accessor.integer("byteOffset", 0, 0, kMostBytes);
  check_component_type(accessor.at("componentType"), false);
  accessor.boolean("normalized", false);
  const std::uint64_t count = accessor.at("count").integer(1, kMostElements);
  check_one_of(accessor.at("type"), {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"});
  const auto sparse = accessor.find("sparse");
  if (!sparse) return;
  // tinygltf holds the count in an int.
  sparse->at("count").integer(1, std::min<std::uint64_t>(count, 0x7fff'ffff));
  for (const char* part : {"indices", "values"}) {
    const View bytes = sparse->at(part);
    bytes.at("bufferView").index(views, "bufferView");
    bytes.integer("byteOffset", 0, 0, kMostSparseOffset);
  }
  check_component_type(sparse->at("indices").at("componentType"), true);
}

void check_buffer_view(const View& view, std::size_t buffers) {
  view.at("buffer").index(buffers, "buffer");
  view.integer("byteOffset", 0, 0, kMostBytes);
  view.at("byteLength").integer(1, kMostBytes);
  if (const auto stride = view.find("byteStride"); stride && stride->integer(4, 252) % 4 != 0)
    stride->fail(fmt::format("found {}, allowed: a multiple of 4", stride->integer(4, 252)));
}

void check_attributes(const View& attributes, std::size_t accessors) {
  attributes.require_object();
  for (const auto& [key, value] : attributes.json().items())
    attributes.at(key).index(accessors, "accessor");
}

void check_mesh(const View& mesh, std::size_t accessors, std::size_t materials) {
  mesh.require_object();
  mesh.text("name", "");
  mesh.at("primitives").require_array(1);
  for_each(mesh, "primitives", [&](const View& primitive) {
    check_attributes(primitive.at("attributes"), accessors);
    primitive.index("indices", accessors, "accessor");
    primitive.index("material", materials, "material");
    primitive.integer("mode", 4, 0, 6);
    for_each(primitive, "targets",
             [&](const View& target) { check_attributes(target, accessors); });
    if (const auto draco = primitive.extension("KHR_draco_mesh_compression"))
      draco->at("bufferView");
  });
  check_numbers(mesh, "weights");
}

/// The member "rotation" of a node or an environment.
void check_rotation(const View& parent) {
  const auto rotation = parent.find("rotation");
  if (!rotation) return;
  double square = 0;
  for (const double x : rotation->numbers(4, {-1e9, 1e9})) square += x * x;
  const double length = std::sqrt(square);
  if (std::fabs(length - 1) > kLengthTolerance)
    rotation->fail(
        fmt::format("found a quaternion of length {:.6g}, allowed: a unit quaternion", length));
}

void check_node(const View& node, const View& root) {
  node.require_object();
  node.text("name", "");
  node.index("camera", count_of(root, "cameras"), "camera");
  node.index("mesh", count_of(root, "meshes"), "mesh");
  node.index("skin", count_of(root, "skins"), "skin");
  if (const auto matrix = node.find("matrix")) matrix->numbers(16);
  node.numbers("translation", {0, 0, 0});
  node.numbers("scale", {1, 1, 1});
  check_rotation(node);
  check_numbers(node, "weights");
}

/// Each node has one parent at most and no node is beneath itself.
void check_trees(const View& root) {
  const std::size_t count = count_of(root, "nodes");
  constexpr std::size_t kNone = SIZE_MAX;
  std::vector<std::size_t> parent(count, kNone);
  std::size_t n = 0;
  for_each(root, "nodes", [&](const View& node) {
    for_each(node, "children", [&](const View& child) {
      const std::size_t c = child.index(count, "node");
      if (parent[c] != kNone)
        child.fail(
            fmt::format("node {} has two parents, nodes {} and {}, allowed: one; nodes form trees",
                        c, parent[c], n));
      parent[c] = n;
    });
    ++n;
  });
  // Follows the parents of each node.  0: not seen, 1: on the present way, 2: leads to a root.
  std::vector<std::uint8_t> state(count, 0);
  StopPoll poll;
  for (std::size_t first = 0; first < count; ++first, poll()) {
    std::size_t i = first;
    for (; i != kNone && state[i] == 0; i = parent[i]) state[i] = 1;
    if (i != kNone && state[i] == 1)
      root.at("nodes")[i].fail(fmt::format("node {} is beneath itself, allowed: trees", i));
    for (i = first; i != kNone && state[i] == 1; i = parent[i]) state[i] = 2;
  }
  for_each(root, "scenes", [&](const View& scene) {
    std::set<std::size_t> roots;
    scene.require_object().text("name", "");
    for_each(scene, "nodes", [&](const View& node) {
      const std::size_t i = node.index(count, "node");
      if (parent[i] != kNone)
        node.fail(fmt::format("node {} has the parent {}, allowed: nodes without a parent", i,
                              parent[i]));
      if (!roots.insert(i).second) node.fail(fmt::format("node {} is named twice", i));
    });
  });
  root.index("scene", count_of(root, "scenes"), "scene");
}

void check_camera(const View& camera) {
  camera.require_object();
  check_one_of(camera.at("type"), {"perspective", "orthographic"});
  const View projection = camera.at(camera.at("type").text());
  projection.require_object();
  if (camera.at("type").text() == "perspective") {
    projection.at("yfov").number({1e-6, std::numbers::pi - 1e-6});
    projection.at("znear").number(kNotNegative);
    projection.number("aspectRatio", 1, {1e-3, 1e3});
  } else {
    for (const char* key : {"xmag", "ymag", "znear", "zfar"}) projection.at(key).number();
  }
}

void check_skin(const View& skin, std::size_t nodes, std::size_t accessors) {
  skin.at("joints").require_array(1);
  for_each(skin, "joints", [&](const View& joint) { joint.index(nodes, "node"); });
  skin.index("inverseBindMatrices", accessors, "accessor");
  skin.index("skeleton", nodes, "node");
}

void check_animation(const View& animation, std::size_t nodes, std::size_t accessors) {
  const std::size_t samplers = animation.at("samplers").require_array(1).size();
  for_each(animation, "samplers", [&](const View& sampler) {
    sampler.at("input").index(accessors, "accessor");
    sampler.at("output").index(accessors, "accessor");
    if (const auto interpolation = sampler.find("interpolation"))
      check_one_of(*interpolation, {"LINEAR", "STEP", "CUBICSPLINE"});
  });
  animation.at("channels").require_array(1);
  for_each(animation, "channels", [&](const View& channel) {
    channel.at("sampler").index(samplers, "sampler");
    const View target = channel.at("target");
    target.index("node", nodes, "node");
    target.at("path").text();
  });
}

}  // namespace

void check_structure(const View& root) {
  const std::size_t accessors = count_of(root, "accessors");
  const std::size_t views = count_of(root, "bufferViews");
  const std::size_t buffers = count_of(root, "buffers");
  const std::size_t materials = count_of(root, "materials");
  const std::size_t nodes = count_of(root, "nodes");
  for_each(root, "buffers",
           [](const View& buffer) { buffer.at("byteLength").integer(1, kMostBytes); });
  for_each(root, "bufferViews", [&](const View& v) { check_buffer_view(v, buffers); });
  for_each(root, "accessors", [&](const View& a) { check_accessor(a, views); });
  for_each(root, "meshes", [&](const View& m) { check_mesh(m, accessors, materials); });
  for_each(root, "nodes", [&](const View& n) { check_node(n, root); });
  check_trees(root);
  for_each(root, "cameras", check_camera);
  for_each(root, "skins", [&](const View& s) { check_skin(s, nodes, accessors); });
  for_each(root, "animations", [&](const View& a) { check_animation(a, nodes, accessors); });
  for (const char* name : {"KHR_lights_punctual", "EXT_lights_ies", "EXT_lights_image_based"}) {
    if (const auto extension = root.extension(name))
      for_each(*extension, "lights", [](const View& light) { light.require_object(); });
  }
  if (const auto environments = root.extension("EXT_lights_image_based"))
    for_each(*environments, "lights", check_rotation);
}

namespace {

/// What happens without an extension that a file may require: the file has a fallback for readers
/// that lack it.  Empty for other extensions.
std::string_view fallback_of(std::string_view name) {
  if (name == "KHR_materials_variants") return "each mesh has its default material";
  if (name == "KHR_materials_pbrSpecularGlossiness")
    return "pbrMetallicRoughness; without it, the diffuse colour with its specular colour and "
           "glossiness";
  if (name == "KHR_texture_basisu") return "the picture in \"source\", else white";
  if (name.find("_materials_") != std::string_view::npos) return "the materials without it";
  if (name == "KHR_animation_pointer") return "the values at rest";
  if (name.starts_with("MSFT_packing_")) return "the textures without it";
  // Metadata, sound, physics, characters and the behaviour of viewers.
  for (const std::string_view known :
       {"KHR_xmp", "KHR_xmp_json_ld", "KHR_audio_emitter", "KHR_implicit_shapes",
        "KHR_interactivity", "KHR_node_hoverability", "KHR_node_selectability",
        "KHR_physics_rigid_bodies", "EXT_mesh_features", "EXT_instance_features",
        "EXT_structural_metadata", "AGI_articulations", "AGI_stk_metadata",
        "CESIUM_primitive_outline", "MSFT_lod", "VRM", "VRMC_node_constraint", "VRMC_springBone",
        "VRMC_vrm"})
    if (name == known) return "ignored";
  return "";
}

}  // namespace

void check_extensions(const View& root) {
  const View version = root.at("asset").at("version");
  if (!version.text().starts_with("2."))
    version.fail(fmt::format("found \"{}\", allowed: \"2.0\"", printable(version.text())));
  if (const auto least = root.at("asset").find("minVersion"); least && least->text() != "2.0")
    least->fail(fmt::format("found \"{}\", allowed: \"2.0\"", printable(least->text())));

  static const std::set<std::string, std::less<>> kModelled{
      "EXT_lights_ies",        "EXT_lights_image_based",     "EXT_mesh_gpu_instancing",
      "KHR_lights_punctual",   "KHR_draco_mesh_compression", "EXT_meshopt_compression",
      "KHR_mesh_quantization", "EXT_texture_webp",           "EXT_texture_avif",
      "MSFT_texture_dds"};
  const auto is_modelled = [](const std::string& name) {
    return kModelled.contains(name) || is_material_extension(name);
  };
  for_each(root, "extensionsRequired", [&](const View& name) {
    if (!is_modelled(name.text()) && fallback_of(name.text()).empty())
      name.fail(absl::InvalidArgumentError(
          fmt::format("the file requires the extension \"{}\", which is not modelled",
                      printable(name.text()))));
  });
  for_each(root, "extensionsUsed", [&](const View& name) {
    if (is_modelled(name.text())) return;
    const std::string_view fallback = fallback_of(name.text());
    root.context().remark(name.pointer(),
                          fmt::format("extension \"{}\" is not modelled", printable(name.text())),
                          fallback.empty() ? "ignored" : std::string(fallback));
  });
}

}  // namespace lucerna::gltf
