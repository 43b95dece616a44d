#include "server/visibility/shadow_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace lucerna {
namespace {

// Rounded up from measurements of one core on the scenes of scenes/.
constexpr double kTexelSeconds = 1e-6;

bool has_moving_surfaces(const Accelerator& accelerator) {
  for (std::uint32_t i = 0; i < accelerator.instance_count(); ++i)
    if (accelerator.instance(i).motion) return true;
  return false;
}

}  // namespace

ShadowMaps::ShadowMaps(const Scene& scene) : scene_(scene), number_(scene.lights().size(), -1) {
  // In an empty scene, rays cost nothing.
  if (scene.geometry().empty() || has_moving_surfaces(scene.geometry().accelerator())) return;
  std::uint64_t faces = 0;
  for (std::size_t l = 0; l < number_.size(); ++l) {
    const auto view = shadow_map_view(scene.lights()[l], scene.sphere());
    if (!view) continue;
    number_[l] = static_cast<std::int32_t>(views_.size());
    views_.push_back(*view);
    faces += view->face_count;
  }
  if (faces == 0) return;
  side_ =
      std::min(kLargestSide, static_cast<std::uint32_t>(std::sqrt(static_cast<double>(kMostTexels) /
                                                                  static_cast<double>(faces))));
  if (side_ < kLeastSide) {
    std::ranges::fill(number_, -1);
    views_.clear();
    return;
  }
  for (std::size_t i = 0; i < views_.size(); ++i) maps_.emplace_back("shadow map");
}

const ShadowMap* ShadowMaps::map(std::uint32_t light) const {
  if (number_[light] < 0) return nullptr;
  const auto i = static_cast<std::size_t>(number_[light]);
  return &maps_[i].get([&] { return std::make_unique<const ShadowMap>(scene_, views_[i], side_); },
                       [](const ShadowMap&) { return "a query looked up this light"; });
}

double ShadowMaps::seconds_left() const {
  std::uint64_t texels = 0;
  for (std::size_t i = 0; i < maps_.size(); ++i)
    if (maps_[i].made() == nullptr) texels += std::uint64_t{views_[i].face_count} * side_ * side_;
  return kTexelSeconds * static_cast<double>(texels);
}

std::uint64_t ShadowMaps::bytes() const {
  std::uint64_t sum = 0;
  for (const auto& map : maps_) sum += map.bytes();
  // The memory of the table of maps counts with the first map.
  if (sum > 0)
    sum += number_.capacity() * sizeof number_[0] + views_.capacity() * sizeof views_[0] +
           maps_.size() * sizeof maps_[0];
  return sum;
}

std::optional<ScenePart> ShadowMaps::report() const {
  ScenePart sum{"shadow maps", 0, 0, ""};
  std::size_t made = 0;
  for (const auto& map : maps_) {
    const auto report = map.report();
    if (!report) continue;
    ++made;
    sum.build_ms += report->build_ms;
  }
  if (made == 0) return std::nullopt;
  sum.bytes = bytes();
  sum.why = fmt::format("a query used shadow maps: {} of {} lights, {} texels a side", made,
                        number_.size(), side_);
  return sum;
}

}  // namespace lucerna
