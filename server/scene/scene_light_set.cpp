// The lights of a scene: their storage, what they share, and how one is chosen.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>

#include "proto/common/status_macros.h"
#include "server/scene/light_at_time.h"
#include "server/scene/scene_builder.h"
#include "server/scene/scene_lights.h"

namespace lucerna {

std::uint32_t Scene::Builder::file_number(const std::string& file) {
  const auto [entry, is_new] =
      file_numbers_.try_emplace(file, static_cast<std::uint32_t>(scene_->files_.size()));
  if (is_new) scene_->files_.push_back(file);
  return entry->second;
}

absl::Status Scene::Builder::add_light(absl::StatusOr<Light<double>> light,
                                       const SourceLocation& where, std::uint32_t samples,
                                       std::unique_ptr<LightMotion> moving) {
  if (!light.ok()) return located(light.status(), where);
  const auto index = static_cast<std::uint32_t>(scene_->lights_.size());
  visit(
      [&]<typename L>(const L& l) {
        if constexpr (SeenBeyond<L>) scene_->infinite_lights_.push_back(index);
        scene_->has_visible_lights_ |= !l.kDelta;
        if constexpr (requires { l.shape(); })
          if (moving != nullptr)
            moving->reach_m =
                std::fmax(max_abs(l.shape().bounds().first), max_abs(l.shape().bounds().second));
      },
      *light);
  scene_->lights_.push_back({.id = index + 1u,
                             .light = *std::move(light),
                             .moving = std::move(moving),
                             .samples = samples,
                             .file = file_number(where.file),
                             .line = where.line,
                             .column = where.column});
  return absl::OkStatus();
}

void Scene::Builder::keep_spectra() {
  const Stopwatch watch;
  std::vector<const std::shared_ptr<const Spectrum>*> given;  // in the order of the lights
  for (const auto& l : in_.lights) given.push_back(&l.spectrum);
  for (const auto& s : in_.shapes)
    if (s.emission) given.push_back(&s.emission->spectrum);
  const auto count =
      std::ranges::count_if(given, [](const auto* spectrum) { return *spectrum != nullptr; });
  if (count == 0) return;
  std::map<const Spectrum*, std::int32_t> numbers;
  std::uint64_t bytes = 0;
  scene_->light_spectra_.reserve(given.size());
  for (const auto* spectrum : given) {
    if (*spectrum == nullptr) {
      scene_->light_spectra_.push_back(-1);
      continue;
    }
    const auto [entry, is_new] =
        numbers.try_emplace(spectrum->get(), static_cast<std::int32_t>(numbers.size()));
    if (is_new) {
      scene_->spectra_.push_back(*spectrum);
      bytes += (*spectrum)->bytes();
    }
    scene_->light_spectra_.push_back(entry->second);
  }
  scene_->spectra_.shrink_to_fit();
  bytes += scene_->spectra_.size() * sizeof scene_->spectra_[0] +
           scene_->light_spectra_.size() * sizeof scene_->light_spectra_[0];
  part("spectra", bytes, watch,
       fmt::format("{} {} of {} {}", numbers.size(), numbers.size() == 1 ? "spectrum" : "spectra",
                   count, count == 1 ? "light" : "lights"));
}

absl::Status Scene::Builder::build_lights() {
  const Stopwatch watch;
  for (const auto& l : in_.lights) {
    Vec3<double> origin = scene_->origin_;
    std::unique_ptr<LightMotion> moving;
    if (l.motion) {
      const std::optional<Vec3<double>> anchor = anchor_of(l);
      // About its own position, so that its coordinates are exact wherever it moves.
      if (anchor) origin = *anchor;
      moving = light_motion(*l.motion, origin);
      moving->only_turns = !anchor;
    }
    LUCERNA_RETURN_IF_ERROR(
        add_light(create_light(l, origin), l.where, l.samples, std::move(moving)));
  }
  std::size_t moving_shape = 0;
  for (const auto& s : in_.shapes) {
    Vec3<double> origin = scene_->origin_;
    // The same origin as that of the surface that rays hit.
    if (s.motion) origin = moving_origins_[moving_shape++];
    if (!s.emission) continue;
    std::unique_ptr<LightMotion> moving;
    if (s.motion) moving = light_motion(*s.motion, origin);
    LUCERNA_RETURN_IF_ERROR(add_light(create_area_light(s, origin), s.emission->where,
                                      s.emission->samples, std::move(moving)));
  }
  if (scene_->lights_.empty()) return absl::OkStatus();
  scene_->lights_.shrink_to_fit();
  std::uint64_t bytes = scene_->lights_.size() * sizeof(SceneLight), table_bytes = 0;
  for (const std::string& file : scene_->files_) bytes += sizeof file + file.size();
  std::size_t tables = 0;
  for (const SceneLight& l : scene_->lights_) {
    const std::uint64_t table = distribution_bytes(l.light);
    bytes += l.light.bytes_beside() + light_bytes(l.light) - table;
    table_bytes += table;
    tables += table > 0;
  }
  part("lights", bytes, watch, fmt::format("{} lights", scene_->lights_.size()));
  if (tables > 0)
    part("image distributions", table_bytes, watch,
         fmt::format("to draw points and directions from the pictures of {} lights", tables));
  keep_spectra();
  report_shared_by_lights(watch);
  return absl::OkStatus();
}

void Scene::Builder::report_shared_by_lights(const Stopwatch& watch) {
  // Lights may share a picture, which counts once.
  std::set<const Image*> images;
  for (const SceneLight& l : scene_->lights_)
    if (const Image* picture = picture_of(l.light)) images.insert(picture);
  std::uint64_t image_bytes = 0;
  for (const Image* image : images) image_bytes += image->bytes();
  if (!images.empty())
    part("images", image_bytes, watch, fmt::format("{} pictures of lights", images.size()));
  // Goniometric lights and panels may share the tables that sample directions.  Each table
  // counts once.
  std::set<std::shared_ptr<const PhotometricWeb>> webs;
  std::set<std::shared_ptr<const IntensityMap>> maps;
  for (const SceneLight& l : scene_->lights_) {
    visit(
        [&](const auto& m) {
          if constexpr (requires { m.shape().profile(); }) webs.insert(m.shape().profile().web);
          if constexpr (requires { webs.insert(m.params().web); }) webs.insert(m.params().web);
          if constexpr (requires { maps.insert(m.params().map); }) maps.insert(m.params().map);
        },
        l.light);
  }
  // Entries of lights without one.
  webs.erase(nullptr);
  maps.erase(nullptr);
  std::uint64_t web_bytes = 0, map_bytes = 0;
  for (const auto& web : webs) web_bytes += web->bytes();
  for (const auto& map : maps) map_bytes += map->table_bytes();
  if (!webs.empty())
    part("photometric webs", web_bytes, watch, fmt::format("{} luminaires", webs.size()));
  if (!maps.empty())
    part("intensity maps", map_bytes, watch,
         fmt::format("to draw directions from {} pictures", maps.size()));
}

namespace {

/// The cross-section that the flux of a light without bounds passes, in a scene with this
/// sphere [m2].
double cross_section_m2(const Light<double>& light, const SceneSphere& sphere) {
  return visit(
      [&](const auto& l) {
        if constexpr (requires { l.params().width_m; }) {
          return l.params().width_m * l.params().height_m;
        } else if constexpr (requires { l.corners_m(); }) {
          const auto corners = l.corners_m();
          return length(cross(corners[1] - corners[0], corners[3] - corners[0]));
        } else {
          return std::numbers::pi * sphere.radius_m * sphere.radius_m;
        }
      },
      light);
}

/// Bounds of the light's positions and directions at all times.  Nothing where its illuminance
/// does not fall off with distance.
std::optional<LightBounds<double>> bounds_of(const SceneLight& light) {
  if (light.light.get_if<BeamLight<double>>() != nullptr) return std::nullopt;
  auto bounds = visit([](const auto& l) { return l.bounds(); }, light.light);
  if (!bounds || light.moving == nullptr) return bounds;
  LightBounds<double> swept = *bounds;
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
  for (std::uint32_t i = 0; i < scene.lights().size(); ++i) {
    const SceneLight& l = scene.lights()[i];
    const LightAtTime at_start(l, -std::numeric_limits<double>::infinity());
    if (areas_alone && at_start.is_delta()) continue;
    const Power power = at_start.power(sphere);
    // The largest channel and not the luminance, because a light of one channel makes noise
    // too.
    const double lumens = std::fmin(power.lumens.max_component(), 1e300);
    auto bounds = bounds_of(l);
    const double lux = bounds ? 0 : std::fmin(lumens / cross_section_m2(l.light, sphere), 1e300);
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
  const double own_ms = watch.ms() - (tree ? tree->build_ms : 0);
  scene_->parts_.push_back({"light choice", selector.bytes() - selector.tree_part().bytes(), own_ms,
                            fmt::format("{} lights to choose from", scene_->lights_.size())});
  return absl::OkStatus();
}

}  // namespace lucerna
