#include "server/scene/movable_surfaces.h"

#include <utility>

#include "lights/models/area_light.h"
#include "proto/common/status_macros.h"
#include "server/description/load_meter.h"
#include "server/rays/surface_table.h"
#include "server/scene/scene_lights.h"

namespace lucerna {
namespace {

/// The emission of a light without a picture and without a profile, as its file gives it.  Without
/// spectrum, name and number of samples, which a light keeps when it moves.
ShapeDescription::Emission emission_of(const SceneLights& lights, const SceneLight& light) {
  ShapeDescription::Emission emission{.radiance_cd_m2 = {}, .where = lights.source_of(light)};
  if (const auto* surface = dynamic_cast<const AreaLight*>(light.light.get())) {
    emission.radiance_cd_m2 = surface->emission().radiance_cd_m2;
    emission.two_sided = surface->emission().two_sided;
    emission.is_unseen = light.is_unseen;
  }
  return emission;
}

}  // namespace

bool MovableSurfaces::is_plain(const ShapeDescription& shape) {
  const auto* mesh = std::get_if<TriangleMeshData>(&shape.geometry);
  return mesh != nullptr && mesh->normals.empty() && mesh->corner_uv.empty() &&
         mesh->colours.empty() && mesh->tangents.empty() && shape.alpha.is_constant() &&
         shape.alpha.constant >= 1 && !shape.media && !shape.is_interface && !shape.motion &&
         !shape.emission->picture && !shape.emission->panel;
}

void MovableSurfaces::add(ShapeDescription&& shape) {
  if (!is_plain(shape)) {
    kept_.emplace_back(std::make_unique<const ShapeDescription>(std::move(shape)));
    return;
  }
  auto& mesh = std::get<TriangleMeshData>(shape.geometry);
  kept_.emplace_back(PlainMesh{std::move(mesh.positions), std::move(mesh.indices)});
}

ShapeDescription MovableSurfaces::shape(std::size_t i, const SceneLights& loaded,
                                        const SceneLight& light) const {
  if (const auto* whole = std::get_if<std::unique_ptr<const ShapeDescription>>(&kept_[i]))
    return **whole;
  const auto& mesh = std::get<PlainMesh>(kept_[i]);
  ShapeDescription shape;
  shape.geometry = TriangleMeshData{mesh.positions, {}, mesh.indices};
  shape.emission = emission_of(loaded, light);
  return shape;
}

absl::StatusOr<std::optional<Bounds>> MovableSurfaces::still_bounds(std::size_t i) const {
  ShapeDescription plain;
  const ShapeDescription* shape = &plain;
  if (const auto* whole = std::get_if<std::unique_ptr<const ShapeDescription>>(&kept_[i])) {
    shape = whole->get();
    if (shape->motion) return std::nullopt;
  } else {
    const auto& mesh = std::get<PlainMesh>(kept_[i]);
    plain.geometry = TriangleMeshData{mesh.positions, {}, mesh.indices};
  }
  LUCERNA_ASSIGN_OR_RETURN(const Bounds bounds, shape_bounds(*shape));
  return bounds;
}

std::uint64_t MovableSurfaces::bytes() const {
  std::uint64_t sum = kept_.capacity() * sizeof(Kept);
  for (const Kept& kept : kept_) {
    if (const auto* whole = std::get_if<std::unique_ptr<const ShapeDescription>>(&kept))
      sum += sizeof(ShapeDescription) + array_bytes(**whole);
    else
      sum += std::get<PlainMesh>(kept).positions.capacity() * sizeof(Vec3) +
             std::get<PlainMesh>(kept).indices.capacity() * sizeof(std::uint32_t);
  }
  return sum;
}

}  // namespace lucerna
