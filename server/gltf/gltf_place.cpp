#include "server/gltf/gltf_place.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "server/gltf/accessor.h"
#include "server/gltf/gltf_mesh.h"

namespace lucerna::gltf {
namespace {

/// A place of a mesh in the world.
struct MeshPlace {
  Transform world_from_mesh;
  std::shared_ptr<const Motion> motion;
  std::size_t node = 0;
};

bool has_area(const TriangleMeshData& mesh) {
  StopPoll poll;
  for (std::size_t i = 0; i + 3 <= mesh.indices.size(); i += 3, poll()) {
    const auto corner = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
    if (max_abs(cross(corner(1) - corner(0), corner(2) - corner(0))) > 0) return true;
  }
  return false;
}

class Placer {
 public:
  Placer(const Document& document, Materials& materials, const Tree& tree)
      : document_(document), context_(document.context()), materials_(materials), tree_(tree) {}

  void place() {
    for (const PlacedNode& node : tree_.nodes()) find_places(node);
    for (const auto& [mesh, places] : places_) {
      const std::vector<Part> parts = make_parts(document_, materials_, mesh, {});
      add(mesh, parts, places);
    }
  }

 private:
  void find_places(const PlacedNode& node);
  void find_instances(const PlacedNode& node, const View& instancing, std::size_t mesh);
  void add_place(const PlacedNode& node, const Matrix& world_from_mesh, std::size_t mesh);
  void add_deformed(const PlacedNode& node, std::size_t mesh);
  void add(std::size_t mesh, const std::vector<Part>& parts, const std::vector<MeshPlace>& places);
  void add_parts(std::size_t mesh, const std::vector<Part>& parts,
                 const std::vector<MeshPlace>& places);
  void add_shape(const Part& part, const MeshPlace* place);
  void count(const ShapeDescription& shape, const Part& part);

  const Document& document_;
  LoadState& context_;
  Materials& materials_;
  const Tree& tree_;
  std::map<std::size_t, std::vector<MeshPlace>> places_;  ///< by mesh
};

std::string node_pointer(std::size_t node) { return fmt::format("/nodes/{}", node); }

void Placer::find_places(const PlacedNode& node) {
  context_.poll();
  const tinygltf::Node& n = document_.model().nodes[node.index];
  if (n.mesh < 0) return;
  const auto mesh = static_cast<std::size_t>(n.mesh);
  const View place = document_.root().at("nodes")[node.index];
  if (n.skin >= 0 || !n.weights.empty()) {
    add_deformed(node, mesh);
  } else if (const auto instancing = place.extension("EXT_mesh_gpu_instancing")) {
    find_instances(node, *instancing, mesh);
  } else {
    add_place(node, node.world_from_node, mesh);
  }
}

void Placer::add_place(const PlacedNode& node, const Matrix& world_from_mesh, std::size_t mesh) {
  const auto transform = Transform::from_matrix(world_from_mesh);
  if (!transform) {
    context_.remark(node_pointer(node.index),
                    "a transform without an inverse, such as a scale of 0", "its mesh is left out");
    return;
  }
  context_.claim_for_good(node_pointer(node.index), 1,
                          sizeof(MeshPlace) + sizeof(InstanceDescription));
  places_[mesh].push_back({*transform, node.motion, node.index});
}

void Placer::find_instances(const PlacedNode& node, const View& instancing, std::size_t mesh) {
  const View attributes = instancing.at("attributes");
  attributes.require_object();
  std::optional<std::size_t> count;
  const auto read = [&](const char* name, std::size_t components) {
    std::vector<double> values;
    const auto given = attributes.find(name);
    if (!given) return values;
    values = read_numbers(document_, given->index(document_.model().accessors.size(), "accessor"),
                          components);
    const std::size_t found = values.size() / components;
    if (count && found != *count)
      given->fail(fmt::format("found {} elements, but other attributes have {}", found, *count));
    count = found;
    return values;
  };
  const std::vector<double> translation = read("TRANSLATION", 3);
  const std::vector<double> rotation = read("ROTATION", 4);
  const std::vector<double> scale = read("SCALE", 3);
  if (!count) {
    instancing.context().remark(instancing.pointer(),
                                "instances without TRANSLATION, ROTATION or SCALE", "one instance");
    add_place(node, node.world_from_node, mesh);
    return;
  }
  const auto vec = [](const std::vector<double>& v, std::size_t i, double otherwise) {
    return v.empty() ? Vec3{otherwise, otherwise, otherwise}
                     : Vec3{v[3 * i], v[3 * i + 1], v[3 * i + 2]};
  };
  StopPoll poll;
  for (std::size_t i = 0; i < *count; ++i, poll()) {
    Quaternion turn{0, 0, 0, 1};
    if (!rotation.empty()) std::copy_n(&rotation[4 * i], 4, turn.begin());
    if (turn == Quaternion{})
      attributes.at("ROTATION").fail(fmt::format("element {} is 0, allowed: a quaternion", i));
    add_place(
        node,
        multiply(node.world_from_node, from_parts(vec(translation, i, 0), turn, vec(scale, i, 1))),
        mesh);
  }
}

/// A mesh with its own weights or with a skin is not shared with other nodes.
void Placer::add_deformed(const PlacedNode& node, std::size_t mesh) {
  const tinygltf::Node& n = document_.model().nodes[node.index];
  Deformation deformation{n.weights, {}};
  MeshPlace place{Transform(), node.motion, node.index};
  if (n.skin < 0) {
    const auto transform = Transform::from_matrix(node.world_from_node);
    if (!transform) return;
    place.world_from_mesh = *transform;
  } else {
    // The node's own transform does not count.  [glTF2, 3.7.3.3]
    place.motion = nullptr;
    const tinygltf::Skin& skin = document_.model().skins[static_cast<std::size_t>(n.skin)];
    std::vector<double> inverses;
    if (skin.inverseBindMatrices >= 0)
      inverses = read_numbers(document_, static_cast<std::size_t>(skin.inverseBindMatrices), 16);
    if (!inverses.empty() && inverses.size() < 16 * skin.joints.size())
      context_.fail(fmt::format("/skins/{}/inverseBindMatrices", n.skin),
                    fmt::format("found {} matrices, but there are {} joints", inverses.size() / 16,
                                skin.joints.size()));
    if (std::ranges::any_of(skin.joints, [this](int joint) {
          return tree_.is_animated(static_cast<std::size_t>(joint));
        }))
      context_.remark(fmt::format("/skins/{}", n.skin), "an animation of joints",
                      "the mesh at rest");
    for (std::size_t i = 0; i < skin.joints.size(); ++i) {
      const Matrix joint = tree_.at_rest(static_cast<std::size_t>(skin.joints[i]));
      deformation.joints.push_back(
          inverses.empty() ? joint : multiply(joint, from_columns(&inverses[16 * i])));
    }
  }
  add(mesh, make_parts(document_, materials_, mesh, deformation), {place});
}

void Placer::add_shape(const Part& part, const MeshPlace* place) {
  ShapeDescription shape;
  context_.poll();
  context_.claim(part.pointer, part.mesh.positions.size(), sizeof(Vec3) + sizeof(Vec3f));
  shape.material = part.use.material;
  shape.where = context_.location(part.pointer);
  shape.has_uv = part.use.uv_set.has_value();
  shape.alpha = part.use.alpha;
  if (place == nullptr) {
    shape.geometry = part.mesh;
    count(shape, part);
    context_.scene.objects.back().shapes.push_back(std::move(shape));
    return;
  }
  shape.geometry =
      transformed(context_, node_pointer(place->node), part.mesh, place->world_from_mesh);
  shape.motion = place->motion;
  if (part.use.emission != nullptr && has_area(std::get<TriangleMeshData>(shape.geometry))) {
    ShapeDescription::Emission emission;
    emission.radiance_cd_m2 = part.use.emission->radiance_cd_m2;
    emission.picture = part.use.emission->picture;
    emission.two_sided = part.use.double_sided;
    emission.where = context_.location(node_pointer(place->node));
    const tinygltf::Model& model = document_.model();
    const tinygltf::Node& node = model.nodes[place->node];
    emission.name =
        context_.light_name(node_pointer(place->node),
                            {node.name, model.meshes[static_cast<std::size_t>(node.mesh)].name});
    shape.emission = std::move(emission);
  }
  count(shape, part);
  context_.scene.shapes.push_back(std::move(shape));
}

void Placer::count(const ShapeDescription& shape, const Part& part) {
  if (absl::Status status = context_.meter.add(shape); !status.ok())
    context_.fail(part.pointer, status);
}

void Placer::add(std::size_t mesh, const std::vector<Part>& parts,
                 const std::vector<MeshPlace>& places) {
  add_parts(mesh, parts, places);
  context_.end_scratch();  // the caller drops the parts
}

void Placer::add_parts(std::size_t mesh, const std::vector<Part>& parts,
                       const std::vector<MeshPlace>& places) {
  // Objects cannot emit.
  bool has_object = false;
  for (const Part& part : parts) {
    if (part.use.emission || places.size() == 1) {
      for (const MeshPlace& place : places) add_shape(part, &place);
      continue;
    }
    if (!has_object) {
      const std::string name = printable(document_.model().meshes[mesh].name);
      context_.scene.objects.push_back({name.empty() ? fmt::format("/meshes/{}", mesh) : name, {}});
      has_object = true;
    }
    add_shape(part, nullptr);
  }
  if (!has_object) return;
  const auto object = static_cast<std::uint32_t>(context_.scene.objects.size() - 1);
  StopPoll poll;
  for (const MeshPlace& place : places)
    poll(), context_.scene.instances.push_back({object, place.world_from_mesh, place.motion,
                                                context_.location(node_pointer(place.node))});
}

}  // namespace

void place_meshes(const Document& document, Materials& materials, const Tree& tree) {
  Placer(document, materials, tree).place();
}

}  // namespace lucerna::gltf
