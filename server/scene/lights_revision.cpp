#include "server/scene/lights_revision.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lights/maths/level_validation.h"
#include "lights/models/area_light.h"
#include "proto/common/status_macros.h"
#include "server/scene/create_light.h"
#include "server/scene/lights_builder.h"

namespace lucerna {
namespace {

absl::Status about_light(std::uint64_t id, const absl::Status& status) {
  return {status.code(), fmt::format("light {}: {}", id, std::string(status.message()))};
}

/// The light with another level.
absl::StatusOr<LightPointer> with_level(const Light& light, const LightChange& change) {
  const auto* const area = dynamic_cast<const AreaLight*>(&light);
  if (area == nullptr) return absl::InternalError("a light without a surface");
  DiffuseEmission emission = area->emission();
  emission.radiance_cd_m2 = changed_level(change, emission.radiance_cd_m2);
  LUCERNA_RETURN_IF_ERROR(
      check_light_value("light.level", emission.radiance_cd_m2, "cd/m2", kMostInAnswers));
  return area->with_emission(emission);
}

/// A light of a scene without edits that has no surface, as its file gives it.
LightDescription describe(const SceneLights& loaded, std::uint32_t light) {
  const SceneLight& of = loaded[light];
  LightDescription d{.params = of.light->made_from().value_or(LightParams()),
                     .where = loaded.source_of(of),
                     .samples = of.samples,
                     .name = std::string(loaded.names().of(light))};
  if (const auto number = loaded.spectrum_number(light)) d.spectrum = loaded.spectra()[*number];
  if (of.moving != nullptr) d.motion = of.moving->world;
  return d;
}

/// Makes the lights step by step.
class LightsRevision {
 public:
  LightsRevision(const SceneLights& loaded, const SceneGeometry& geometry, const LightEdits& edits,
                 const std::stop_token& stop);

  absl::StatusOr<std::shared_ptr<const SceneLights>> revise();

 private:
  bool is_replaced(std::uint32_t i) const { return edits_.added.contains(loaded_[i].id); }
  bool is_unchanged(std::uint32_t i) const { return changes_[i] == LightChange(); }
  LightChange change_of(std::uint64_t id) const {
    const auto found = edits_.changes.find(id);
    return found != edits_.changes.end() ? found->second : LightChange();
  }
  /// Describes the lights without a surface that must be made anew, as they are now.
  absl::Status describe_lights();
  absl::Status describe_added();
  absl::Status make_lights(LightsBuilder& builder);
  /// Whether a light of the file is made from its description.
  bool is_described(std::uint32_t i) const {
    return is_replaced(i) ||
           (!loaded_[i].light->has_surface() && (is_elsewhere_ || !is_unchanged(i)));
  }
  void note(std::uint32_t i, LightsBuilder& builder) const;
  absl::StatusOr<SceneLight> made(std::uint32_t i, LightsBuilder& builder) const;
  absl::Status make_added(LightsBuilder& builder);
  absl::StatusOr<SceneLight> made_surface(std::uint64_t id, const AddedSurface& surface,
                                          LightsBuilder& builder) const;

  const SceneLights& loaded_;
  const SceneGeometry& geometry_;
  const LightEdits& edits_;
  const std::stop_token& stop_;
  const std::uint32_t count_;
  std::vector<LightChange> changes_;  // of each light of the file
  // Levels do not change where the scene is.  Otherwise all lights without a surface determine it.
  bool only_levels_;
  bool has_gaps_;
  bool is_elsewhere_ = false;                               // with another origin
  std::vector<std::optional<LightDescription>> described_;  // of each light of the file
  std::vector<std::pair<std::uint64_t, LightDescription>> added_;
  LongList<LightDescription> free_;  // all without a surface, unless only levels change
  std::uint64_t bytes_ = 0;          // of lights that edits changed
};

LightsRevision::LightsRevision(const SceneLights& loaded, const SceneGeometry& geometry,
                               const LightEdits& edits, const std::stop_token& stop)
    : loaded_(loaded),
      geometry_(geometry),
      edits_(edits),
      stop_(stop),
      count_(static_cast<std::uint32_t>(loaded.size())),
      changes_(count_),
      described_(count_) {
  for (const auto& [id, change] : edits.changes)
    if (id >= 1 && id <= count_) changes_[id - 1] = change;
  has_gaps_ = std::ranges::any_of(changes_, [](const LightChange& c) { return c.is_removed; });
  only_levels_ = edits.added.empty() && !has_gaps_ &&
                 std::ranges::none_of(changes_, [](const LightChange& c) { return c.has_place(); });
}

absl::Status LightsRevision::describe_lights() {
  for (std::uint32_t i = 0; i < count_; ++i) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop_));
    const SceneLight& of = loaded_[i];
    if (changes_[i].is_removed || (only_levels_ && is_unchanged(i))) continue;
    const auto replacement = edits_.added.find(of.id);
    if (replacement != edits_.added.end())
      described_[i] = replacement->second.light;
    else if (of.light->has_surface())
      continue;
    else
      described_[i] = describe(loaded_, i);
    if (absl::Status s = apply(changes_[i], *described_[i]); !s.ok()) return about_light(of.id, s);
    if (!only_levels_) free_.push_back(*described_[i]);
  }
  return absl::OkStatus();
}

absl::Status LightsRevision::describe_added() {
  for (const auto& [id, a] : edits_.added) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop_));
    if (id <= count_) continue;
    added_.emplace_back(id, a.light);
    if (a.surface != nullptr) continue;
    LightDescription& light = added_.back().second;
    if (absl::Status s = apply(change_of(id), light); !s.ok()) return about_light(id, s);
    free_.push_back(light);
  }
  return absl::OkStatus();
}

void LightsRevision::note(std::uint32_t i, LightsBuilder& builder) const {
  if (is_described(i)) {
    builder.note(described_[i]->spectrum, described_[i]->name);
    return;
  }
  const auto number = loaded_.spectrum_number(i);
  builder.note(number && changes_[i].keeps_spectrum() ? loaded_.spectra()[*number] : nullptr,
               loaded_.names().of(i));
}

absl::StatusOr<SceneLight> LightsRevision::made(std::uint32_t i, LightsBuilder& builder) const {
  const SceneLight& of = loaded_[i];
  if (is_described(i)) return builder.free_light(of.id, *described_[i]);
  SceneLight revised(of);
  const auto moved = geometry_.edited_lights().find(of.id);
  if (moved != geometry_.edited_lights().end()) revised.light = moved->second.light;
  if (!changes_[i].has_level()) return revised;
  LUCERNA_ASSIGN_OR_RETURN(revised.light, with_level(*revised.light, changes_[i]));
  return revised;
}

absl::Status LightsRevision::make_lights(LightsBuilder& builder) {
  LightsData& data = builder.data();
  // Without gaps, all lights keep their places, and blocks without edits stay shared.
  if (!has_gaps_) data.all = loaded_.data().all;
  bool has_other_numbers = !geometry_.edits().added.empty();
  std::uint32_t next = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop_));
    // The surface of a light that is gone stays and is dark.
    const bool is_dark = changes_[i].is_removed || is_replaced(i);
    has_other_numbers |= is_dark;
    data.of_surfaces.push_back(is_dark ? -1 : static_cast<std::int32_t>(next));
    if (changes_[i].is_removed) continue;
    const std::uint32_t at = next++;
    note(i, builder);
    if (!has_gaps_ && is_unchanged(i) && !is_described(i)) continue;
    absl::StatusOr<SceneLight> light = made(i, builder);
    if (!light.ok()) return about_light(loaded_[i].id, light.status());
    if (is_dark || !is_unchanged(i)) bytes_ += kLightHeapBytes + light->light->own_bytes().object;
    if (has_gaps_)
      data.all.push_back(*std::move(light));
    else
      data.all.replace(at, *std::move(light));
  }
  if (!has_other_numbers) data.of_surfaces = {};
  return absl::OkStatus();
}

absl::StatusOr<SceneLight> LightsRevision::made_surface(std::uint64_t id,
                                                        const AddedSurface& surface,
                                                        LightsBuilder& builder) const {
  const ShapeDescription::Emission& emission = *surface.shape.emission;
  const LightChange change = change_of(id);
  builder.note(change.keeps_spectrum() ? emission.spectrum : nullptr, emission.name);
  LUCERNA_ASSIGN_OR_RETURN(
      SceneLight made, builder.area_light(id, geometry_.edited_lights().at(id).light, emission));
  if (!change.has_level()) return made;
  LUCERNA_ASSIGN_OR_RETURN(made.light, with_level(*made.light, change));
  return made;
}

absl::Status LightsRevision::make_added(LightsBuilder& builder) {
  LightsData& data = builder.data();
  for (const auto& [id, light] : added_) {
    const AddedSurface* const surface = edits_.added.at(id).surface.get();
    if (surface == nullptr) builder.note(light.spectrum, light.name);
    absl::StatusOr<SceneLight> made =
        surface == nullptr ? builder.free_light(id, light) : made_surface(id, *surface, builder);
    if (!made.ok()) return about_light(id, made.status());
    if (surface != nullptr) data.of_surfaces.push_back(static_cast<std::int32_t>(data.all.size()));
    data.all.push_back(*std::move(made));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const SceneLights>> LightsRevision::revise() {
  LUCERNA_RETURN_IF_ERROR(describe_lights());
  LUCERNA_RETURN_IF_ERROR(describe_added());
  SceneFrame frame = loaded_.frame();
  if (!only_levels_) {
    LUCERNA_ASSIGN_OR_RETURN(frame, scene_frame(geometry_.world_m(), free_, stop_));
  }
  is_elsewhere_ = !(frame.origin == loaded_.frame().origin);
  LightsBuilder builder(frame, &loaded_);
  LUCERNA_RETURN_IF_ERROR(make_lights(builder));
  LUCERNA_RETURN_IF_ERROR(make_added(builder));
  const LightsData& data = builder.data();
  builder.report(data.all.size() - added_.size(),
                 bytes_ + edits_.bytes() + data.all.bytes_beside(loaded_.data().all) +
                     data.of_surfaces.capacity() * sizeof(std::int32_t),
                 fmt::format("{} lights, {} of them edited", data.all.size(),
                             edits_.changes.size() + edits_.added.size()));
  return builder.finish();
}

}  // namespace

absl::StatusOr<std::shared_ptr<const SceneLights>> revised_lights(const SceneLights& loaded,
                                                                  const SceneGeometry& geometry,
                                                                  const LightEdits& edits,
                                                                  const std::stop_token& stop) {
  return LightsRevision(loaded, geometry, edits, stop).revise();
}

}  // namespace lucerna
