#include "server/description/scene_contents.h"

#include <array>
#include <set>
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

/// Counts by the index of a variant.
template <std::size_t kSize>
class Kinds {
 public:
  void add(std::size_t kind, std::uint64_t primitives = 0, std::uint64_t without_area = 0) {
    ++counts_[kind];
    primitives_[kind] += primitives;
    without_area_[kind] += without_area;
  }
  std::vector<KindCount> by(const std::array<std::string_view, kSize>& names) const {
    std::vector<KindCount> result;
    for (std::size_t i = 0; i < kSize; ++i)
      if (counts_[i] > 0)
        result.push_back({std::string(names[i]), counts_[i], primitives_[i], without_area_[i]});
    return result;
  }

 private:
  std::array<std::uint64_t, kSize> counts_{}, primitives_{}, without_area_{};
};

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
  Kinds<kShapes.size()> shapes;
  std::set<std::uint32_t> used;
  const auto add = [&](const ShapeDescription& shape) {
    shapes.add(shape.geometry.index(), primitives_of(shape), without_area(shape));
    used.insert(shape.material);
  };
  StopPoll poll;
  for (const ShapeDescription& shape : scene.shapes) poll(), add(shape);
  for (const ObjectDefinition& object : scene.objects)
    for (const ShapeDescription& shape : object.shapes) poll(), add(shape);
  contents.shapes = shapes.by(kShapes);
  contents.objects = scene.objects.size();
  contents.instances = scene.instances.size();

  // Parts of a mix come before it, so one pass from the last to the first finds all.
  Kinds<kMaterials.size()> materials;
  for (std::size_t i = scene.materials.size(); i-- > 0; poll()) {
    if (!used.contains(static_cast<std::uint32_t>(i))) continue;
    materials.add(scene.materials[i].params.index());
    if (const auto* mix = std::get_if<MixParams>(&scene.materials[i].params))
      used.insert(mix->materials.begin(), mix->materials.end());
  }
  contents.materials = materials.by(kMaterials);

  Kinds<kTextures.size()> textures;
  for (const TextureNode& node : scene.textures.nodes()) textures.add(node.index());
  for (const Textures::Picture& p : scene.textures.pictures())
    contents.pictures.push_back({p.name, p.texels->width(), p.texels->height(), p.texels->bytes()});
  contents.textures = textures.by(kTextures);

  const auto projection = static_cast<std::size_t>(scene.camera.projection);
  contents.camera = kCameras[projection];
  if (scene.camera.lens_radius > 0 && projection < 2) contents.camera += " with a lens";
  return contents;
}

}  // namespace lucerna
