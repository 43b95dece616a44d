// A loaded scene with other lights.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "lights/spectra/level_validation.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/runtime/denormals.h"
#include "server/scene/scene_builder.h"
#include "server/scene/create_light.h"

namespace lucerna {
namespace {

absl::Status about_light(std::uint64_t id, const absl::Status& status) {
  return {status.code(), fmt::format("light {}: {}", id, std::string(status.message()))};
}

/// The light with another level.
absl::StatusOr<std::shared_ptr<const Light>> with_level(const Light& light,
                                                        const LightChange& change) {
  const auto* const surface = dynamic_cast<const SurfaceLight*>(&light);
  if (surface == nullptr) return absl::InternalError("a light without a surface");
  DiffuseEmission emission = surface->emission();
  emission.radiance_cd_m2 = changed_level(change, emission.radiance_cd_m2);
  LUCERNA_RETURN_IF_ERROR(
      check_light_value("light.level", emission.radiance_cd_m2, "cd/m2", kMostInAnswers));
  return surface->with_emission(emission);
}

}  // namespace

LightDescription Scene::Builder::describe(const Scene& loaded, std::uint32_t light) {
  const SceneLight& of = loaded.lights_[light];
  LightDescription d{.params = of.light->made_from().value_or(LightParams()),
                     .where = loaded.source_of(of),
                     .samples = of.samples,
                     .name = std::string(loaded.light_names_.of(light))};
  if (const auto number = loaded.spectrum_number(light)) d.spectrum = loaded.spectra_[*number];
  if (of.moving != nullptr) d.motion = of.moving->world;
  return d;
}

absl::StatusOr<SceneLight> Scene::Builder::revised_light(SceneLight next,
                                                         const LightChange& change) {
  if (change.has_level()) {
    LUCERNA_ASSIGN_OR_RETURN(next.light, with_level(*next.light, change));
  }
  return next;
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::Builder::revise(
    std::shared_ptr<const Scene> from, std::shared_ptr<const PlacedSurfaces> placed,
    LightEdits edits) {
  const DenormalsAreZero denormals;
  const Stopwatch watch;
  const Scene& loaded = *from;
  scene_->base_ = from.get();
  scene_->loaded_ = std::move(from);
  scene_->placed_ = std::move(placed);
  const auto count = static_cast<std::uint32_t>(loaded.lights_.size());

  if (scene_->placed_->edits != loaded.surface_edits(edits))
    return absl::InternalError("surfaces that are elsewhere");
  LUCERNA_RETURN_IF_ERROR(check_panes(loaded, edits));
  std::vector<LightChange> changes(count);
  for (const auto& [id, change] : edits.changes)
    if (id >= 1 && id <= count) changes[id - 1] = change;
  // Levels do not change where the scene is.  Otherwise all lights without a surface determine it.
  const bool only_levels =
      edits.added.empty() && std::ranges::none_of(changes, [](const LightChange& c) {
        return c.is_removed || c.has_place();
      });
  std::vector<std::optional<LightDescription>> described(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    const SceneLight& of = loaded.lights_[i];
    if (changes[i].is_removed || (only_levels && changes[i] == LightChange())) continue;
    const auto replacement = edits.added.find(of.id);
    if (replacement != edits.added.end())
      described[i] = replacement->second.light;
    else if (of.light->has_surface())
      continue;
    else
      described[i] = describe(loaded, i);
    if (absl::Status s = apply(changes[i], *described[i]); !s.ok()) return about_light(of.id, s);
    if (!only_levels) in_.lights.push_back(*described[i]);
  }
  std::vector<std::pair<std::uint64_t, LightDescription>> added;
  for (const auto& [id, a] : edits.added) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    if (id <= count) continue;
    added.emplace_back(id, a.light);
    if (a.surface != nullptr) continue;
    if (const auto change = edits.changes.find(id); change != edits.changes.end())
      if (absl::Status s = apply(change->second, added.back().second); !s.ok())
        return about_light(id, s);
    in_.lights.push_back(added.back().second);
  }
  if (only_levels) {
    scene_->origin_ = loaded.origin_;
    scene_->sphere_ = loaded.sphere_;
  } else {
    LUCERNA_RETURN_IF_ERROR(place_lights());
  }

  scene_->files_ = loaded.files_;
  for (std::uint32_t i = 0; i < scene_->files_.size(); ++i)
    file_numbers_.emplace(scene_->files_[i], i);
  const bool is_elsewhere = !(scene_->origin_ == loaded.origin_);
  std::vector<std::shared_ptr<const Spectrum>> spectra;
  std::vector<std::pair<std::uint32_t, std::string>> names;
  const auto note = [&](const std::shared_ptr<const Spectrum>& spectrum, std::string_view name) {
    if (!name.empty()) names.emplace_back(static_cast<std::uint32_t>(spectra.size()), name);
    spectra.push_back(spectrum);
  };
  bool has_other_numbers = !scene_->placed_->edits.added.empty();
  std::uint64_t bytes = 0;
  // Without gaps, all lights keep their places, and blocks without edits stay shared.
  const bool has_gaps =
      std::ranges::any_of(changes, [](const LightChange& c) { return c.is_removed; });
  if (!has_gaps) scene_->lights_ = loaded.lights_;
  std::uint32_t at = 0;  // of the next light
  for (std::uint32_t i = 0; i < count; ++i) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    const SceneLight& of = loaded.lights_[i];
    const bool is_replaced = edits.added.contains(of.id);
    // The surface of a light that is gone stays and is dark.
    const bool is_dark = changes[i].is_removed || is_replaced;
    has_other_numbers |= is_dark;
    scene_->light_numbers_.push_back(is_dark ? -1 : static_cast<std::int32_t>(at));
    if (changes[i].is_removed) continue;
    const std::uint32_t number_here = at++;
    absl::StatusOr<SceneLight> made = absl::InternalError("no light");
    if (is_replaced ||
        (!of.light->has_surface() && (is_elsewhere || changes[i] != LightChange()))) {
      note(described[i]->spectrum, described[i]->name);
      made = free_light(of.id, *described[i]);
    } else {
      const auto number = loaded.spectrum_number(i);
      note(number && changes[i].keeps_spectrum() ? loaded.spectra_[*number] : nullptr,
           loaded.light_names_.of(i));
      if (!has_gaps && changes[i] == LightChange()) continue;
      SceneLight revised(of);
      const auto moved = scene_->placed_->lights.find(of.id);
      if (moved != scene_->placed_->lights.end()) revised.light = moved->second.light;
      made = revised_light(std::move(revised), changes[i]);
    }
    if (!made.ok()) return about_light(of.id, made.status());
    if (is_dark || changes[i] != LightChange())
      bytes += kLightHeapBytes + made->light->own_bytes().object;
    if (has_gaps)
      scene_->lights_.push_back(*std::move(made));
    else
      scene_->lights_.replace(number_here, *std::move(made));
  }
  if (!has_other_numbers) scene_->light_numbers_ = {};
  for (const auto& [id, light] : added) {
    const AddedSurface* const surface = edits.added.at(id).surface.get();
    absl::StatusOr<SceneLight> made = absl::InternalError("no light");
    if (surface == nullptr) {
      note(light.spectrum, light.name);
      made = free_light(id, light);
    } else {
      const ShapeDescription::Emission& emission = *surface->shape.emission;
      const auto found = edits.changes.find(id);
      const LightChange change = found != edits.changes.end() ? found->second : LightChange();
      note(change.keeps_spectrum() ? emission.spectrum : nullptr, emission.name);
      made = scene_light(id, scene_->placed_->lights.at(id).light, emission.where, emission.samples,
                         nullptr);
      if (made.ok()) made->is_unseen = emission.is_unseen;
      if (made.ok()) made = revised_light(*std::move(made), change);
      scene_->light_numbers_.push_back(static_cast<std::int32_t>(scene_->lights_.size()));
    }
    if (!made.ok()) return about_light(id, made.status());
    scene_->lights_.push_back(*std::move(made));
  }
  note_visible_lights();
  StopPoll poll;
  for (const SceneLight& l : scene_->lights_) poll(), scene_->moves_ |= l.moving != nullptr;
  scene_->others_move_ = loaded.others_move_;
  scene_->moves_ |= scene_->others_move_;

  const std::size_t added_from = scene_->lights_.size() - added.size();
  for (std::size_t i = added_from; i < scene_->lights_.size(); ++i, poll()) {
    const LightBytes own = scene_->lights_[i].light->own_bytes();
    bytes += kLightHeapBytes + own.object + own.data;
  }
  light_part("lights",
             bytes + edits.bytes() + scene_->lights_.bytes_beside(loaded.lights_) +
                 scene_->light_numbers_.capacity() * sizeof(std::int32_t),
             watch,
             fmt::format("{} lights, {} of them edited", scene_->lights_.size(),
                         edits.changes.size() + edits.added.size()));
  keep_spectra(spectra);
  keep_names(std::move(names));
  report_shared_by_lights(added_from, watch);
  scene_->camera_ = Camera(loaded.camera_description_, loaded.film_, scene_->origin_);
  scene_->id_ = hexadecimal(sha256("edited:" + loaded.id_ + ":" + edits.canonical()));
  scene_->edits_ = std::move(edits);
  return scene_;
}

SurfaceEdits Scene::surface_edits(const LightEdits& edits) const {
  SurfaceEdits of;
  StopPoll poll;
  for (const auto& [id, light] : edits.added) {
    poll();
    if (light.surface != nullptr) of.added.emplace(id, light);
  }
  for (const auto& [id, change] : edits.changes) {
    poll();
    if (!change.has_place() || change.is_removed) continue;
    const bool is_of_file = id <= base_->lights_.size() && !edits.added.contains(id) &&
                            base_->lights_[id - 1].light->has_surface();
    if (is_of_file || of.added.contains(id)) of.moved[id] = place_only(change);
  }
  return of;
}

absl::Status Scene::Builder::check_panes(const Scene& loaded, const LightEdits& edits) {
  // Light passes a pane of thin glass straight on, unless it emits.
  const auto is_pane = [&](const Surface& surface) {
    if (surface.is_interface || loaded.materials().empty()) return false;
    const Material& material = loaded.materials()[surface.material];
    return std::holds_alternative<ThinDielectricParams>(material.params) && material.normal_map < 0;
  };
  const auto check = [&](const SurfaceTable& table) -> absl::Status {
    for (const Surface& surface : table.surfaces) {
      if (surface.light < 0 || !is_pane(surface)) continue;
      const std::uint64_t id = loaded.lights_[static_cast<std::size_t>(surface.light)].id;
      const auto change = edits.changes.find(id);
      if (edits.added.contains(id) || (change != edits.changes.end() && change->second.is_removed))
        return about_light(id, absl::InvalidArgumentError(
                                   "removal of a pane of thin glass that emits, allowed: off"));
    }
    return absl::OkStatus();
  };
  LUCERNA_RETURN_IF_ERROR(check(loaded.surfaces()));
  for (const SurfaceTable& table : loaded.object_surfaces_) LUCERNA_RETURN_IF_ERROR(check(table));
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::revise(
    std::shared_ptr<const Scene> loaded, std::shared_ptr<const PlacedSurfaces> placed,
    LightEdits edits, std::stop_token stop) {
  if (edits.empty() && loaded->placed_->edits.empty()) return loaded;
  SceneDescription lights;
  return Builder(lights, std::move(stop))
      .revise(std::move(loaded), std::move(placed), std::move(edits));
}

absl::StatusOr<std::shared_ptr<const Scene>> Scene::revise(std::shared_ptr<const Scene> loaded,
                                                           LightEdits edits) {
  const SurfaceEdits surfaces = loaded->surface_edits(edits);
  std::shared_ptr<const PlacedSurfaces> placed = loaded->placed_;
  if (placed->edits != surfaces) {
    LUCERNA_ASSIGN_OR_RETURN(placed, place(*loaded, surfaces));
    if (placed == nullptr)
      return absl::FailedPreconditionError("edits of surfaces that need the scene's files again");
  }
  return revise(std::move(loaded), std::move(placed), std::move(edits));
}

}  // namespace lucerna
