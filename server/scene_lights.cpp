#include "server/scene_lights.h"

#include <type_traits>
#include <utility>

#include "server/surface_table.h"

namespace lucerna {

std::optional<Vec3<double>> position_of(const LightDescription& light) {
  if (const auto* p = std::get_if<PointLightParams>(&light.params)) return p->position_m;
  if (const auto* p = std::get_if<SpotLightParams>(&light.params)) return p->position_m;
  if (const auto* p = std::get_if<GoniometricLightParams>(&light.params)) return p->position_m;
  return std::nullopt;
}

namespace {

template <template <typename> typename Model, typename Params>
absl::StatusOr<Light<float>> as_light(const Params& params, const Vec3<double>& origin) {
  auto light = Model<float>::create(params, origin);
  if (!light.ok()) return light.status();
  return Light<float>(*std::move(light));
}

}  // namespace

absl::StatusOr<Light<float>> create_light(const LightDescription& light,
                                          const Vec3<double>& origin) {
  return std::visit(
      [&](const auto& params) -> absl::StatusOr<Light<float>> {
        using Params = std::decay_t<decltype(params)>;
        if constexpr (std::is_same_v<Params, PointLightParams>)
          return as_light<PointLight>(params, origin);
        else if constexpr (std::is_same_v<Params, SpotLightParams>)
          return as_light<SpotLight>(params, origin);
        else if constexpr (std::is_same_v<Params, DistantLightParams>)
          return as_light<DistantLight>(params, origin);
        else if constexpr (std::is_same_v<Params, SunLightParams>)
          return as_light<SunLight>(params, origin);
        else if constexpr (std::is_same_v<Params, ImageInfiniteLightParams>)
          return as_light<ImageInfiniteLight>(params, origin);
        else if constexpr (std::is_same_v<Params, GoniometricLightParams>)
          return as_light<GoniometricLight>(params, origin);
        else
          return as_light<UniformInfiniteLight>(params, origin);
      },
      light.params);
}

namespace {

template <template <typename> typename Shape>
absl::StatusOr<Light<float>> as_area_light(const DiffuseEmission& emission,
                                           absl::StatusOr<Shape<float>> shape) {
  if (!shape.ok()) return shape.status();
  if (absl::Status s = shape->emissive_error(); !s.ok()) return s;
  auto light = AreaLight<float, Shape>::create(emission, *std::move(shape));
  if (!light.ok()) return light.status();
  return Light<float>(*std::move(light));
}

}  // namespace

absl::StatusOr<Light<float>> create_area_light(const ShapeDescription& shape,
                                               const Vec3<double>& origin) {
  const DiffuseEmission emission{shape.emission->radiance_cd_m2, shape.emission->two_sided};
  if (const auto* sphere = std::get_if<SphereParams>(&shape.geometry))
    return as_area_light<Sphere>(emission, Sphere<float>::create(*sphere, origin));
  if (const auto* disk = std::get_if<DiskParams>(&shape.geometry))
    return as_area_light<Disk>(emission, Disk<float>::create(*disk, origin));
  if (const auto* cylinder = std::get_if<CylinderParams>(&shape.geometry))
    return as_area_light<Cylinder>(emission, Cylinder<float>::create(*cylinder, origin));
  if (const auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry)) {
    const auto vertex = [&](std::size_t i) {
      return about(mesh->positions[mesh->indices[i]], origin);
    };
    std::vector<Triangle<float>> triangles(mesh->indices.size() / 3);
    for (std::size_t i = 0; i < triangles.size(); ++i)
      triangles[i] = {vertex(3 * i), vertex(3 * i + 1), vertex(3 * i + 2)};
    return as_area_light<TriangleMesh>(emission, TriangleMesh<float>::create(std::move(triangles)));
  }
  const auto& mesh = std::get<PatchMeshData>(shape.geometry);
  const auto vertex = [&](std::size_t i) { return about(mesh.positions[mesh.indices[i]], origin); };
  std::vector<BilinearPatch<float>> patches(mesh.indices.size() / 4);
  for (std::size_t i = 0; i < patches.size(); ++i)
    patches[i] = {vertex(4 * i), vertex(4 * i + 1), vertex(4 * i + 2), vertex(4 * i + 3)};
  return as_area_light<PatchMesh>(emission, PatchMesh<float>::create(std::move(patches)));
}

std::uint64_t light_bytes(const Light<float>& light) {
  return std::visit(
      [](const auto& l) -> std::uint64_t {
        if constexpr (requires { l.shape().bytes(); })
          return l.shape().bytes();
        else if constexpr (requires { l.table_bytes(); })
          return l.table_bytes();
        else
          return 0;
      },
      light);
}

}  // namespace lucerna
