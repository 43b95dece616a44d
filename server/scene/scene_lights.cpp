#include "server/scene/scene_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "server/scene/light_at_time.h"

namespace lucerna {
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

// kAll visits each light once, so each is equally likely.
LightSelection selection_of_one(LightSelection how) {
  return how == LightSelection::kAll ? LightSelection::kUniform : how;
}

}  // namespace

SceneLights::SceneLights(LightsData data) : data_(std::move(data)) {
  StopPoll poll;
  for (std::uint32_t i = 0; i < data_.all.size(); ++i, poll()) {
    const SceneLight& light = data_.all[i];
    data_.moves |= light.moving != nullptr;
    if (light.light->is_seen_beyond()) data_.infinite.push_back(i);
    data_.has_visible |= !light.light->is_delta() && !light.is_unseen;
  }
}

std::optional<std::uint32_t> SceneLights::find(std::uint64_t id) const {
  // Ids ascend; without edits there are no gaps.
  const auto found = std::ranges::lower_bound(data_.all, id, {}, &SceneLight::id);
  if (found == data_.all.end() || found->id != id) return std::nullopt;
  return static_cast<std::uint32_t>(found - data_.all.begin());
}

std::vector<LightSelector::Item> SceneLights::selector_items(bool areas_alone) const {
  // Light from infinity arrives at receivers even if the scene is a single point.
  SceneSphere sphere = data_.frame.sphere;
  if (!(sphere.radius_m > 0)) sphere.radius_m = 1;
  std::vector<LightSelector::Item> items;
  StopPoll poll;
  for (std::uint32_t i = 0; i < size(); ++i, poll()) {
    const SceneLight& l = data_.all[i];
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

const LightSelector& SceneLights::make_selector() const {
  return selector_.get(
      [this] { return std::make_unique<const LightSelector>(selector_items(false)); },
      [this](const LightSelector&) { return fmt::format("{} lights to choose from", size()); });
}

const LightSelector& SceneLights::area_selector() const {
  return area_selector_.get(
      [this] { return std::make_unique<const LightSelector>(selector_items(true)); },
      [](const LightSelector&) { return "a query sampled lights other than delta lights"; });
}

std::optional<LightChoice> SceneLights::choose(LightSelection how, const Receiver& receiver,
                                               double u) const {
  if (size() == 1) return LightChoice{0, 1};
  return selector().choose(selection_of_one(how), receiver, u);
}

double SceneLights::probability(LightSelection how, const Receiver& receiver,
                                std::uint32_t light) const {
  if (size() == 1) return 1;
  return selector().probability(selection_of_one(how), receiver, light);
}

LightChoice SceneLights::choose_emitter(double u) const {
  if (size() == 1) return {0, 1};
  return selector().by_flux().choose(u);
}

std::vector<ScenePart> SceneLights::parts() const {
  std::vector<ScenePart> all = data_.parts;
  all.insert(all.end(), data_.pictures.begin(), data_.pictures.end());
  for (const auto* part : {&selector_, &area_selector_}) {
    if (auto selector = part->report()) all.push_back(*std::move(selector));
    if (const LightSelector* made = part->made())
      if (auto tree = made->tree_part().report()) all.push_back(*std::move(tree));
  }
  return all;
}

std::uint64_t SceneLights::bytes() const {
  std::uint64_t sum = bytes_of(data_.parts) + bytes_of(data_.pictures);
  for (const auto* part : {&selector_, &area_selector_}) {
    sum += part->bytes();
    if (const LightSelector* made = part->made()) sum += made->tree_part().bytes();
  }
  return sum;
}

}  // namespace lucerna
