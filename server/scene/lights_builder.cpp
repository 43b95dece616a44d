#include "server/scene/lights_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/description/load_meter.h"
#include "server/scene/create_light.h"

namespace lucerna {

LightsBuilder::LightsBuilder(const SceneFrame& frame, const SceneLights* loaded) {
  data_.frame = frame;
  if (loaded == nullptr) return;
  data_.files = loaded->data().files;
  for (std::uint32_t i = 0; i < data_.files.size(); ++i) file_numbers_.emplace(data_.files[i], i);
}

std::uint32_t LightsBuilder::file_number(const std::string& file) {
  const auto [entry, is_new] =
      file_numbers_.try_emplace(file, static_cast<std::uint32_t>(data_.files.size()));
  if (is_new) data_.files.push_back(file);
  return entry->second;
}

std::unique_ptr<LightMotion> LightsBuilder::motion_about(
    const std::shared_ptr<const Motion>& motion, const Vec3& from) const {
  return std::make_unique<LightMotion>(LightMotion{
      .motion = motion->about(from, data_.frame.origin), .origin_m = from, .world = motion});
}

absl::StatusOr<SceneLight> LightsBuilder::scene_light(std::uint64_t id,
                                                      absl::StatusOr<LightPointer> light,
                                                      const SourceLocation& where,
                                                      std::uint32_t samples,
                                                      std::unique_ptr<LightMotion> moving) {
  if (!light.ok()) return located(light.status(), where);
  if (moving != nullptr && (*light)->has_surface()) {
    const LightBounds box = *(*light)->bounds();
    moving->reach_m = static_cast<float>(std::fmax(max_abs(box.lower), max_abs(box.upper)));
  }
  return SceneLight{.id = id,
                    .light = *std::move(light),
                    .moving = std::move(moving),
                    .samples = samples,
                    .file = file_number(where.file),
                    .line = where.line,
                    .column = where.column};
}

absl::StatusOr<SceneLight> LightsBuilder::free_light(std::uint64_t id,
                                                     const LightDescription& light) {
  Vec3 origin = data_.frame.origin;
  std::unique_ptr<LightMotion> moving;
  if (light.motion) {
    const std::optional<Vec3> anchor = place_of(light).anchor_m;
    // Relative to its own anchor: its coordinates are then exact for every motion.
    if (anchor) origin = *anchor;
    moving = motion_about(light.motion, origin);
    moving->only_turns = !anchor;
  }
  return scene_light(id, create_light(light, origin), light.where, light.samples,
                     std::move(moving));
}

absl::StatusOr<SceneLight> LightsBuilder::area_light(std::uint64_t id,
                                                     absl::StatusOr<LightPointer> light,
                                                     const ShapeDescription::Emission& emission,
                                                     std::unique_ptr<LightMotion> moving) {
  LUCERNA_ASSIGN_OR_RETURN(SceneLight made, scene_light(id, std::move(light), emission.where,
                                                        emission.samples, std::move(moving)));
  made.is_unseen = emission.is_unseen;
  return made;
}

void LightsBuilder::note(const std::shared_ptr<const Spectrum>& spectrum, std::string_view name) {
  if (!name.empty()) names_.emplace_back(static_cast<std::uint32_t>(spectra_.size()), name);
  spectra_.push_back(spectrum);
}

/// Stores spectra separately from the lights, so that scenes with only RGB lights store nothing.
void LightsBuilder::keep_spectra() {
  const auto count =
      std::ranges::count_if(spectra_, [](const auto& spectrum) { return spectrum != nullptr; });
  if (count == 0) return;
  std::map<const Spectrum*, std::int32_t> numbers;
  std::uint64_t bytes = 0;
  data_.light_spectra.reserve(spectra_.size());
  StopPoll poll;
  for (const auto& spectrum : spectra_) {
    poll();
    if (spectrum == nullptr) {
      data_.light_spectra.push_back(-1);
      continue;
    }
    const auto [entry, is_new] =
        numbers.try_emplace(spectrum.get(), static_cast<std::int32_t>(numbers.size()));
    if (is_new) {
      data_.spectra.push_back(spectrum);
      bytes += spectrum->bytes();
    }
    data_.light_spectra.push_back(entry->second);
  }
  data_.spectra.shrink_to_fit();
  bytes += data_.spectra.size() * sizeof data_.spectra[0] +
           data_.light_spectra.size() * sizeof data_.light_spectra[0];
  part("spectra", bytes,
       fmt::format("{} {} of {} {}", numbers.size(), numbers.size() == 1 ? "spectrum" : "spectra",
                   count, count == 1 ? "light" : "lights"));
}

/// Stores names separately from the lights, so that lights without a name store nothing.
void LightsBuilder::keep_names() {
  if (names_.empty()) return;
  data_.names = LightNames(std::move(names_));
  const LightNames& names = data_.names;
  part("light names", names.bytes(),
       fmt::format("{} {} of {} {}", names.size(), names.size() == 1 ? "name" : "names",
                   names.light_count(), names.light_count() == 1 ? "light" : "lights"));
}

void LightsBuilder::report(std::size_t from, std::uint64_t bytes, std::string why) {
  std::uint64_t table_bytes = 0;
  std::size_t tables = 0;
  StopPoll poll;
  for (std::size_t i = from; i < data_.all.size(); ++i, poll()) {
    const SceneLight& l = data_.all[i];
    const LightBytes own = l.light->own_bytes();
    bytes += kLightHeapBytes + own.object + own.data - own.tables;
    table_bytes += own.tables;
    tables += own.tables > 0;
  }
  part("lights", bytes, std::move(why));
  if (tables > 0)
    data_.pictures.push_back(
        {"image distributions", table_bytes, 1e3 * watch_.seconds(),
         fmt::format("to draw points and directions from the pictures of {} lights", tables)});
  report_pictures(from);
}

namespace {

/// Data that lights share, each object once.
struct SharedByLights {
  std::set<const Image*> images;
  std::set<const PhotometricWeb*> webs;
  std::set<const IntensityMap*> maps;

  /// A new kind of data does not compile here until it is counted.
  void add(const SharedData& of_light) {
    const auto [image, web, map] = of_light;
    if (image != nullptr) images.insert(image);
    if (web != nullptr) webs.insert(web);
    if (map != nullptr) maps.insert(map);
  }
};

}  // namespace

/// Pictures, webs and maps that the lights from this index on share.
void LightsBuilder::report_pictures(std::size_t from) {
  SharedByLights shared;
  StopPoll poll;
  for (std::size_t i = from; i < data_.all.size(); ++i, poll())
    shared.add(data_.all[i].light->shared_data());
  const auto report = [&](const char* name, const auto& all, const auto& bytes_of,
                          const char* why) {
    std::uint64_t bytes = 0;
    for (const auto* one : all) bytes += bytes_of(*one);
    if (!all.empty())
      data_.pictures.push_back(
          {name, bytes, 1e3 * watch_.seconds(), fmt::format(fmt::runtime(why), all.size())});
  };
  const auto bytes_of = [](const auto& one) { return one.bytes(); };
  report("images", shared.images, bytes_of, "{} pictures of lights");
  report("photometric webs", shared.webs, bytes_of, "{} luminaires");
  report(
      "intensity maps", shared.maps, [](const IntensityMap& map) { return map.table_bytes(); },
      "to draw directions from {} pictures");
}

std::shared_ptr<const SceneLights> LightsBuilder::finish() {
  keep_spectra();
  keep_names();
  return std::make_shared<const SceneLights>(std::move(data_));
}

absl::Status count_lights(const SceneDescription& scene, LoadBudget& budget) {
  const auto emits = [](const ShapeDescription& s) { return s.emission.has_value(); };
  const std::uint64_t count =
      scene.lights.size() + static_cast<std::uint64_t>(std::ranges::count_if(scene.shapes, emits));
  // For the choice of a light: an item and two nodes of the tree.
  constexpr std::uint64_t kChoiceBytes = 256;
  constexpr std::uint64_t kLightBytes = sizeof(SceneLight) + sizeof(PointLight) + kLightHeapBytes;
  std::uint64_t bytes = count * (kLightBytes + (count > 1 ? kChoiceBytes : 0));
  // The triangles of an emitter, and a table to draw from them.
  StopPoll poll;
  for (const ShapeDescription& s : scene.shapes) {
    poll();
    if (s.emission) bytes += array_bytes(s);
  }
  return budget.claim(bytes);
}

absl::StatusOr<std::shared_ptr<const SceneLights>> build_lights(const SceneDescription& scene,
                                                                const ShapeExtents& extents,
                                                                const SceneFrame& frame,
                                                                const std::stop_token& stop) {
  LightsBuilder builder(frame);
  SharedBlocks<SceneLight>& all = builder.data().all;
  for (const auto& l : scene.lights) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop));
    builder.note(l.spectrum, l.name);
    LUCERNA_ASSIGN_OR_RETURN(SceneLight light, builder.free_light(all.size() + 1, l));
    all.push_back(std::move(light));
  }
  std::size_t moving_shape = 0;
  for (const auto& s : scene.shapes) {
    LUCERNA_RETURN_IF_ERROR(check_stop(stop));
    // The same origin as that of the surface that rays hit.
    const Vec3& origin = s.motion ? extents.moving_origins[moving_shape++] : frame.origin;
    if (!s.emission) continue;
    builder.note(s.emission->spectrum, s.emission->name);
    LUCERNA_ASSIGN_OR_RETURN(
        SceneLight light,
        builder.area_light(all.size() + 1, create_area_light(s, origin), *s.emission,
                           s.motion ? builder.motion_about(s.motion, origin) : nullptr));
    all.push_back(std::move(light));
  }
  if (!all.empty()) {
    all.shrink_to_fit();
    std::uint64_t bytes = all.bytes_beside({});
    for (const std::string& file : builder.data().files) bytes += sizeof file + file.size();
    builder.report(0, bytes, fmt::format("{} lights", all.size()));
  }
  return builder.finish();
}

}  // namespace lucerna
