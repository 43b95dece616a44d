// The lights of a scene: their storage, their shared data, and the choice of a light.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/description/load_meter.h"
#include "server/scene/emitter_alpha.h"
#include "server/scene/light_at_time.h"
#include "server/scene/scene_builder.h"
#include "server/scene/create_light.h"

namespace lucerna {

std::uint32_t Scene::Builder::file_number(const std::string& file) {
  const auto [entry, is_new] =
      file_numbers_.try_emplace(file, static_cast<std::uint32_t>(scene_->files_.size()));
  if (is_new) scene_->files_.push_back(file);
  return entry->second;
}

absl::StatusOr<SceneLight> Scene::Builder::scene_light(
    std::uint64_t id, absl::StatusOr<std::shared_ptr<const Light>> light,
    const SourceLocation& where, std::uint32_t samples, std::unique_ptr<LightMotion> moving) {
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

void Scene::Builder::note_visible_lights() {
  StopPoll poll;
  for (std::uint32_t i = 0; i < scene_->lights_.size(); ++i, poll()) {
    const SceneLight& l = scene_->lights_[i];
    if (l.light->is_seen_beyond()) scene_->infinite_lights_.push_back(i);
    scene_->has_visible_lights_ |= !l.light->is_delta() && !l.is_unseen;
  }
}

absl::StatusOr<SceneLight> Scene::Builder::free_light(std::uint64_t id,
                                                      const LightDescription& light) {
  Vec3 origin = scene_->origin_;
  std::unique_ptr<LightMotion> moving;
  if (light.motion) {
    const std::optional<Vec3> anchor = place_of(light).anchor_m;
    // Relative to its own anchor: its coordinates are then exact for every motion.
    if (anchor) origin = *anchor;
    moving = light_motion(light.motion, origin);
    moving->only_turns = !anchor;
  }
  return scene_light(id, create_light(light, origin), light.where, light.samples,
                     std::move(moving));
}

/// `given`: of each light, null for RGB.
void Scene::Builder::keep_spectra(const std::vector<std::shared_ptr<const Spectrum>>& given) {
  const Stopwatch watch;
  const auto count =
      std::ranges::count_if(given, [](const auto& spectrum) { return spectrum != nullptr; });
  if (count == 0) return;
  std::map<const Spectrum*, std::int32_t> numbers;
  std::uint64_t bytes = 0;
  scene_->light_spectra_.reserve(given.size());
  StopPoll poll;
  for (const auto& spectrum : given) {
    poll();
    if (spectrum == nullptr) {
      scene_->light_spectra_.push_back(-1);
      continue;
    }
    const auto [entry, is_new] =
        numbers.try_emplace(spectrum.get(), static_cast<std::int32_t>(numbers.size()));
    if (is_new) {
      scene_->spectra_.push_back(spectrum);
      bytes += spectrum->bytes();
    }
    scene_->light_spectra_.push_back(entry->second);
  }
  scene_->spectra_.shrink_to_fit();
  bytes += scene_->spectra_.size() * sizeof scene_->spectra_[0] +
           scene_->light_spectra_.size() * sizeof scene_->light_spectra_[0];
  light_part(
      "spectra", bytes, watch,
      fmt::format("{} {} of {} {}", numbers.size(), numbers.size() == 1 ? "spectrum" : "spectra",
                  count, count == 1 ? "light" : "lights"));
}

void Scene::Builder::keep_names(std::vector<std::pair<std::uint32_t, std::string>> named) {
  const Stopwatch watch;
  if (named.empty()) return;
  scene_->light_names_ = LightNames(std::move(named));
  const LightNames& names = scene_->light_names_;
  light_part("light names", names.bytes(), watch,
             fmt::format("{} {} of {} {}", names.size(), names.size() == 1 ? "name" : "names",
                         names.light_count(), names.light_count() == 1 ? "light" : "lights"));
}

absl::Status Scene::Builder::count_lights() const {
  if (budget_ == nullptr) return absl::OkStatus();
  const auto emits = [](const ShapeDescription& s) { return s.emission.has_value(); };
  const std::uint64_t count =
      in_.lights.size() + static_cast<std::uint64_t>(std::ranges::count_if(in_.shapes, emits));
  // For the choice of a light: an item and two nodes of the tree.
  constexpr std::uint64_t kChoiceBytes = 256;
  constexpr std::uint64_t kLightBytes = sizeof(SceneLight) + sizeof(PointLight) + kLightHeapBytes;
  std::uint64_t bytes = count * (kLightBytes + (count > 1 ? kChoiceBytes : 0));
  // The triangles of an emitter, and a table to draw from them.
  StopPoll poll;
  for (const ShapeDescription& s : in_.shapes) {
    poll();
    if (s.emission) bytes += array_bytes(s);
  }
  return budget_->claim(bytes);
}

absl::Status Scene::Builder::build_lights() {
  const Stopwatch watch;
  std::vector<std::shared_ptr<const Spectrum>> spectra;
  std::vector<std::pair<std::uint32_t, std::string>> names;
  std::uint32_t count = 0;
  const auto add = [&](const auto& l) {
    spectra.push_back(l.spectrum);
    if (!l.name.empty()) names.emplace_back(count, l.name);
    return ++count;
  };
  for (const auto& l : in_.lights) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    LUCERNA_ASSIGN_OR_RETURN(SceneLight light, free_light(add(l), l));
    scene_->lights_.push_back(std::move(light));
  }
  std::size_t moving_shape = 0;
  for (auto& s : in_.shapes) {
    LUCERNA_RETURN_IF_ERROR(check_stop());
    if (s.emission && (!s.alpha.is_constant() || s.alpha.constant < 1)) {
      if (auto what = apply_alpha(s, in_.textures))
        in_.remarks.push_back({s.where, *std::move(what), "opaque"});
      scene_->has_cut_lights_ = true;
    }
    Vec3 origin = scene_->origin_;
    // The same origin as that of the surface that rays hit.
    if (s.motion) origin = moving_origins_[moving_shape++];
    if (!s.emission) continue;
    std::unique_ptr<LightMotion> moving;
    if (s.motion) moving = light_motion(s.motion, origin);
    LUCERNA_ASSIGN_OR_RETURN(
        SceneLight light, scene_light(add(*s.emission), create_area_light(s, origin),
                                      s.emission->where, s.emission->samples, std::move(moving)));
    light.is_unseen = s.emission->is_unseen;
    scene_->lights_.push_back(std::move(light));
  }
  if (scene_->lights_.empty()) return absl::OkStatus();
  note_visible_lights();
  report_lights(watch);
  keep_spectra(spectra);
  keep_names(std::move(names));
  report_shared_by_lights(0, watch);
  return absl::OkStatus();
}

void Scene::Builder::report_lights(const Stopwatch& watch) {
  scene_->lights_.shrink_to_fit();
  std::uint64_t bytes = scene_->lights_.bytes_beside({}), table_bytes = 0;
  for (const std::string& file : scene_->files_) bytes += sizeof file + file.size();
  std::size_t tables = 0;
  StopPoll poll;
  for (const SceneLight& l : scene_->lights_) {
    poll();
    const LightBytes own = l.light->own_bytes();
    bytes += kLightHeapBytes + own.object + own.data - own.tables;
    table_bytes += own.tables;
    tables += own.tables > 0;
  }
  light_part("lights", bytes, watch, fmt::format("{} lights", scene_->lights_.size()));
  if (tables > 0)
    part("image distributions", table_bytes, watch,
         fmt::format("to draw points and directions from the pictures of {} lights", tables));
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

void Scene::Builder::report_shared_by_lights(std::size_t from, const Stopwatch& watch) {
  SharedByLights shared;
  StopPoll poll;
  for (std::size_t i = from; i < scene_->lights_.size(); ++i, poll())
    shared.add(scene_->lights_[i].light->shared_data());
  std::uint64_t image_bytes = 0, web_bytes = 0, map_bytes = 0;
  for (const Image* image : shared.images) image_bytes += image->bytes();
  for (const PhotometricWeb* web : shared.webs) web_bytes += web->bytes();
  for (const IntensityMap* map : shared.maps) map_bytes += map->table_bytes();
  if (!shared.images.empty())
    part("images", image_bytes, watch, fmt::format("{} pictures of lights", shared.images.size()));
  if (!shared.webs.empty())
    part("photometric webs", web_bytes, watch, fmt::format("{} luminaires", shared.webs.size()));
  if (!shared.maps.empty())
    part("intensity maps", map_bytes, watch,
         fmt::format("to draw directions from {} pictures", shared.maps.size()));
}

namespace {

/// Bounds of the light's place and directions over all time; nothing for lights at infinity.
std::optional<LightBounds> bounds_of(const SceneLight& light) {
  auto bounds = light.light->bounds();
  if (!bounds || light.moving == nullptr) return bounds;
  LightBounds swept = *bounds;
  swept.cone_rad = swept.normals_rad = std::numbers::pi;
  std::tie(swept.lower, swept.upper) = light.moving->motion.bounds(bounds->lower, bounds->upper);
  return swept;
}

}  // namespace

std::vector<LightSelector::Item> selector_items(const Scene& scene, bool areas_alone) {
  // Light from infinity arrives at receivers even if the scene is a single point.
  SceneSphere sphere = scene.sphere();
  if (!(sphere.radius_m > 0)) sphere.radius_m = 1;
  std::vector<LightSelector::Item> items;
  StopPoll poll;
  for (std::uint32_t i = 0; i < scene.lights().size(); ++i, poll()) {
    const SceneLight& l = scene.lights()[i];
    const LightAtTime at_start(l, -std::numeric_limits<double>::infinity());
    if (areas_alone && at_start->is_delta()) continue;
    const Power power = at_start->power(sphere);
    // The largest channel and not the luminance: a light of one channel also causes noise.
    const double lumens = std::fmin(power.lumens.max_component(), 1e300);
    const std::optional<double> section_m2 = l.light->cross_section_m2(sphere);
    auto bounds = section_m2 ? std::nullopt : bounds_of(l);
    const double lux = section_m2 ? std::fmin(lumens / *section_m2, 1e300) : 0;
    items.push_back({i, lumens, lux, std::move(bounds)});
  }
  return items;
}

absl::Status Scene::Builder::prepare_choice() {
  if (scene_->lights_.size() < 2) return absl::OkStatus();
  const Stopwatch watch;
  scene_->light_selector_.emplace(selector_items(*scene_, false));
  LightSelector& selector = *scene_->light_selector_;
  selector.build_tree_if_used();
  // The tree is listed as a separate part.
  const auto tree = selector.tree_part().report();
  const double own_ms = 1e3 * watch.seconds() - (tree ? tree->build_ms : 0);
  scene_->parts_.push_back({"light choice", selector.bytes() - selector.tree_part().bytes(), own_ms,
                            fmt::format("{} lights to choose from", scene_->lights_.size()), true});
  return absl::OkStatus();
}

}  // namespace lucerna
