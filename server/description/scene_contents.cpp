#include "server/description/scene_contents.h"

#include <array>
#include <set>
#include <span>
#include <string_view>

#include "lights/maths/stop_poll.h"
#include "server/description/mesh_census.h"

namespace lucerna {
namespace {

// In the order of the variants.
constexpr auto kMaterials = std::to_array<std::string_view>(
    {"diffuse", "diffusetransmission", "conductor", "dielectric", "thindielectric", "coateddiffuse",
     "coatedconductor", "metallic-roughness", "mix"});
static_assert(kMaterials.size() == std::variant_size_v<MaterialParams>);
constexpr auto kTextures =
    std::to_array<std::string_view>({"imagemap", "checkerboard", "scale", "cut off", "mix",
                                     "directionmix", "bilerp", "dots", "vertex colours"});
static_assert(kTextures.size() == std::variant_size_v<TextureNode>);
constexpr std::array<std::string_view, 4> kCameras{"perspective", "orthographic",
                                                   "spherical, equal area", "spherical"};

constexpr auto kShapes = [] {
  std::array<std::string_view, std::variant_size_v<Geometry>> names{"triangle mesh",
                                                                    "bilinear mesh", "curve"};
  std::size_t next = 3;
  Quadrics::for_each([&]<typename Shape>() { names[next++] = Shape::kName; });
  return names;
}();

/// All kinds, by the index of a variant, without counts.
std::vector<KindCount> kinds_of(std::span<const std::string_view> names) {
  std::vector<KindCount> kinds;
  for (const std::string_view name : names) kinds.push_back({std::string(name)});
  return kinds;
}

std::uint64_t without_area(const ShapeDescription& shape) {
  return std::visit(
      [](const auto& geometry) -> std::uint64_t {
        if constexpr (requires { census_of(geometry); })
          return census_of(geometry).without_area;
        else
          return 0;
      },
      shape.geometry);
}

}  // namespace

std::uint64_t primitives_of(const ShapeDescription& shape) {
  if (const auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry))
    return mesh->indices.size() / 3;
  if (const auto* mesh = std::get_if<PatchMeshData>(&shape.geometry))
    return mesh->indices.size() / 4;
  if (const auto* curve = std::get_if<CurveData>(&shape.geometry)) return curve->count();
  return 1;
}

SceneContents contents_of(const SceneDescription& scene) {
  SceneContents contents;
  contents.shapes = kinds_of(kShapes);
  std::set<std::uint32_t> used;
  const auto add = [&](const ShapeDescription& shape) {
    KindCount& kind = contents.shapes[shape.geometry.index()];
    ++kind.count;
    kind.primitives += primitives_of(shape);
    kind.without_area += without_area(shape);
    used.insert(shape.material);
  };
  StopPoll poll;
  for (const ShapeDescription& shape : scene.shapes) poll(), add(shape);
  for (const ObjectDefinition& object : scene.objects)
    for (const ShapeDescription& shape : object.shapes) poll(), add(shape);
  contents.objects = scene.objects.size();
  contents.instances = scene.instances.size();

  // Parts of a mix come before it, so one pass from the last to the first finds all.
  contents.materials = kinds_of(kMaterials);
  for (std::size_t i = scene.materials.size(); i-- > 0; poll()) {
    if (!used.contains(static_cast<std::uint32_t>(i))) continue;
    ++contents.materials[scene.materials[i].params.index()].count;
    if (const auto* mix = std::get_if<MixParams>(&scene.materials[i].params))
      used.insert(mix->materials.begin(), mix->materials.end());
  }

  contents.textures = kinds_of(kTextures);
  for (const TextureNode& node : scene.textures.nodes()) ++contents.textures[node.index()].count;
  for (const Textures::Picture& p : scene.textures.pictures())
    contents.pictures.push_back({p.name, p.texels->width(), p.texels->height(), p.texels->bytes()});
  for (auto* const kinds : {&contents.shapes, &contents.materials, &contents.textures})
    std::erase_if(*kinds, [](const KindCount& kind) { return kind.count == 0; });

  const auto projection = static_cast<std::size_t>(scene.camera.projection);
  contents.camera = kCameras[projection];
  if (scene.camera.lens_radius > 0 && projection < 2) contents.camera += " with a lens";
  return contents;
}

}  // namespace lucerna
