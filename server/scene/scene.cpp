#include "server/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "lights/maths/stop_poll.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/runtime/denormals.h"
#include "server/scene/emitter_alpha.h"
#include "server/scene/geometry_builder.h"
#include "server/scene/lights_builder.h"
#include "server/scene/lights_revision.h"
#include "server/scene/moved_geometry.h"
#include "server/scene/portal_remarks.h"
#include "server/scene/scene_frame.h"

namespace lucerna {
namespace {

/// Nothing if nothing moves.
std::optional<ScenePart> motion_part(const SceneLights& of_lights, const Accelerator& accelerator,
                                     const Motion* camera) {
  std::uint64_t lights = 0, surfaces = 0, bytes = 0;
  StopPoll poll;
  for (const SceneLight& l : of_lights) {
    poll();
    if (l.moving == nullptr) continue;
    ++lights;
    bytes += sizeof(LightMotion) + l.moving->motion.bytes();
  }
  for (std::uint32_t i = 0; i < accelerator.instance_count(); ++i, poll()) {
    const Motion* motion = accelerator.instance(i).motion.get();
    if (motion == nullptr) continue;
    ++surfaces;
    bytes += sizeof(Motion) + motion->bytes();
  }
  if (camera != nullptr) bytes += sizeof(Motion) + camera->bytes();
  if (lights + surfaces == 0 && camera == nullptr) return std::nullopt;
  return ScenePart{"motion", bytes, 0,
                   fmt::format("{} lights, {} shapes and instances{} move", lights, surfaces,
                               camera != nullptr ? " and the camera" : "")};
}

/// Errors: edits that remove the light of an emissive pane.
absl::Status check_panes(const Scene& loaded, const LightEdits& edits) {
  const SceneGeometry& geometry = loaded.geometry();
  // Light passes a pane of thin glass straight on, unless it emits.
  const auto is_pane = [&](const Surface& surface) {
    if (surface.is_interface || geometry.materials().empty()) return false;
    const Material& material = geometry.materials()[surface.material];
    return std::holds_alternative<ThinDielectricParams>(material.params) && material.normal_map < 0;
  };
  const auto check = [&](const SurfaceTable& table) -> absl::Status {
    for (const Surface& surface : table.surfaces) {
      if (surface.light < 0 || !is_pane(surface)) continue;
      const std::uint64_t id = loaded.lights()[static_cast<std::size_t>(surface.light)].id;
      const auto change = edits.changes.find(id);
      if (edits.added.contains(id) || (change != edits.changes.end() && change->second.is_removed))
        return absl::InvalidArgumentError(
            fmt::format("light {}: removal of a pane of thin glass that emits, allowed: off", id));
    }
    return absl::OkStatus();
  };
  LUCERNA_RETURN_IF_ERROR(check(geometry.surfaces()));
  for (const SurfaceTable& table : geometry.data().fixed->objects)
    LUCERNA_RETURN_IF_ERROR(check(table));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Scene>> Scene::build(SceneDescription description,
                                                          const std::string& isa,
                                                          std::stop_token stop,
                                                          LoadBudget* budget) {
  return build_moved(std::move(description), {}, isa, std::move(stop), budget);
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::build_moved(SceneDescription description,
                                                                const MovedSurfaces& moved,
                                                                const std::string& isa,
                                                                std::stop_token stop,
                                                                LoadBudget* budget) {
  LUCERNA_RETURN_IF_ERROR(move_surfaces(moved, description));
  const DenormalsAreZero denormals;
  LUCERNA_RETURN_IF_ERROR(check_references(description));
  const std::vector<HalvedPicture> halved = description.textures.halved();
  remark_on_halved_pictures(halved, description);
  simplify_media(description);
  SceneContents contents = contents_of(description);
  LUCERNA_ASSIGN_OR_RETURN(const ShapeExtents extents, shape_extents(description, stop));
  LUCERNA_ASSIGN_OR_RETURN(const SceneFrame frame,
                           scene_frame(extents.world_m, description.lights, stop));
  LUCERNA_RETURN_IF_ERROR(remark_on_portals(description, stop));
  if (budget != nullptr) LUCERNA_RETURN_IF_ERROR(count_lights(description, *budget));
  const bool has_cut_lights = apply_alpha(description);
  std::shared_ptr<Scene> scene(new Scene);
  LUCERNA_ASSIGN_OR_RETURN(scene->lights_, build_lights(description, extents, frame, stop));
  LUCERNA_ASSIGN_OR_RETURN(
      scene->geometry_,
      build_geometry(description, extents, frame.origin, has_cut_lights, moved, isa, stop, budget));
  if (scene->lights_->size() > 1) scene->lights_->selector();
  scene->id_ = scene_id(description.assets, halved, description.level_factors);
  scene->camera_ = Camera(description.camera, description.film, scene->origin());
  auto motion = motion_part(*scene->lights_, scene->geometry_->accelerator(),
                            description.camera.motion.get());
  scene->moves_ = motion.has_value();
  scene->report_ =
      std::make_shared<const SceneReport>(SceneReport{.camera = std::move(description.camera),
                                                      .film = std::move(description.film),
                                                      .hints = description.hints,
                                                      .level_factors = description.level_factors,
                                                      .contents = std::move(contents),
                                                      .remarks = std::move(description.remarks),
                                                      .assets = std::move(description.assets),
                                                      .motion = std::move(motion)});
  return scene;
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::revise(
    std::shared_ptr<const Scene> loaded, std::shared_ptr<const SceneGeometry> geometry,
    LightEdits edits, std::stop_token stop) {
  if (edits.empty() && loaded->geometry().edits().empty()) return loaded;
  const DenormalsAreZero denormals;
  if (geometry->edits() != surface_edits(loaded->lights(), edits))
    return absl::InternalError("surfaces that are elsewhere");
  LUCERNA_RETURN_IF_ERROR(check_panes(*loaded, edits));
  std::shared_ptr<Scene> scene(new Scene);
  LUCERNA_ASSIGN_OR_RETURN(scene->lights_,
                           revised_lights(loaded->lights(), *geometry, edits, stop));
  scene->geometry_ = std::move(geometry);
  scene->report_ = loaded->report_;
  scene->camera_ = Camera(scene->report_->camera, scene->report_->film, scene->origin());
  scene->moves_ =
      scene->lights_->moves() || scene->geometry_->moves() || scene->camera_.motion() != nullptr;
  scene->id_ = hexadecimal(sha256("edited:" + loaded->id_ + ":" + edits.canonical()));
  scene->edits_ = std::move(edits);
  scene->loaded_ = std::move(loaded);
  return scene;
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::revise(std::shared_ptr<const Scene> loaded,
                                                           LightEdits edits) {
  const SurfaceEdits surfaces = surface_edits(loaded->lights(), edits);
  std::shared_ptr<const SceneGeometry> geometry = loaded->geometry_;
  if (geometry->edits() != surfaces) {
    LUCERNA_ASSIGN_OR_RETURN(geometry, moved_geometry(*geometry, loaded->lights(), surfaces));
    if (geometry == nullptr)
      return absl::FailedPreconditionError("edits of surfaces that need the scene's files again");
  }
  return revise(std::move(loaded), std::move(geometry), std::move(edits));
}

std::int32_t Scene::surface_number(const SceneLight& light) const {
  // It may have the id of a lamp that it replaces.
  if (!light.light->has_surface()) return kNoSurface;
  if (light.id <= without_edits().lights().size()) return static_cast<std::int32_t>(light.id - 1);
  const auto added = geometry_->edited_lights().find(light.id);
  return added != geometry_->edited_lights().end() ? added->second.number : kNoSurface;
}

std::vector<ScenePart> Scene::parts() const {
  std::vector<ScenePart> all = geometry_->parts();
  const auto add = [&](const std::vector<ScenePart>& parts) {
    all.insert(all.end(), parts.begin(), parts.end());
  };
  if (loaded_ != nullptr) {
    if (has_own_geometry()) add(loaded_->geometry_->parts());
    add(loaded_->lights_->data().pictures);
  }
  if (report_->motion) all.push_back(*report_->motion);
  add(lights_->parts());
  attached_.add_reports(all);
  return all;
}

std::uint64_t Scene::own_bytes() const {
  std::uint64_t sum = lights_->bytes() + attached_.bytes();
  if (has_own_geometry()) sum += geometry_->bytes();
  if (loaded_ == nullptr && report_->motion) sum += report_->motion->bytes;
  return sum;
}

}  // namespace lucerna
