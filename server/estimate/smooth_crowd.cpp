// Light by way of many smooth surfaces.
#include <algorithm>
#include <cmath>

#include "server/estimate/smooth_light.h"

namespace lucerna {
namespace {

/// More lamps than this count as one place.
constexpr std::size_t kMostTargets = 20;

}  // namespace

auto SmoothLight::target_of(const SceneLight& light) -> std::optional<LightTarget> {
  if (light.moving != nullptr) return std::nullopt;
  const LightAtTime at(light, 0);
  if (const auto bounds = at->bounds()) {
    const Vec3 middle = bounds->lower * 0.5 + bounds->upper * 0.5;
    return LightTarget{false, middle, length(bounds->upper - middle)};
  }
  const auto* sun = dynamic_cast<const SunLight*>(light.light.get());
  if (!at->is_delta() && sun == nullptr) return std::nullopt;
  const Vec3 wi = at->sample_li(Receiver(Vec3{}), {}).wi;
  return LightTarget{true, wi, sun == nullptr ? 0 : sun->params().angular_diameter_rad};
}

void SmoothLight::find_targets() {
  paths_use_targets_ = !has_unsized_;
  for (std::size_t l = 0; l < scene_.lights().size(); ++l) {
    const auto place = target_of(scene_.lights()[l]);
    has_target_.push_back(place.has_value());
    if (place) targets_.push_back(*place);
    paths_use_targets_ &= place.has_value() || is_everywhere_[l];
  }
  Bounds all;
  for (const LightTarget& p : targets_)
    if (!p.is_direction) all.add(p.middle);
  // Many lamps are in one place.
  if (targets_.size() > kMostTargets && !all.empty()) {
    const Vec3 middle = all.lower * 0.5 + all.upper * 0.5;
    LightTarget one{false, middle, 0};
    for (const LightTarget& p : targets_)
      if (!p.is_direction) one.radius = std::fmax(one.radius, length(p.middle - middle) + p.radius);
    std::erase_if(targets_, [](const LightTarget& p) { return !p.is_direction; });
    targets_.push_back(one);
  }
}

bool SmoothLight::may_mirror(const Vertex& v, const PartTree::Node& node) const {
  return std::ranges::any_of(targets_, [&](const LightTarget& place) {
    return place.is_direction ? node.may_mirror_from(v.hit.position, place.middle, place.radius)
                              : node.may_mirror(v.hit.position, place.middle, place.radius);
  });
}

// Of many surfaces, a receiver visits those that alone may send light to it.  On paths one is
// chosen.  Random walks find lights without a size by way of several; directions find the others.
void SmoothLight::sample_crowd(const Vertex& v, const Sequence& root, Choices& choices,
                               const PathSample& s, WorkCounts& work, const AddLight& found) const {
  const PartTree& tree = surfaces_.tree();
  const bool visits = v.is_receiver && !targets_.empty();
  std::uint32_t number = 0;
  Nexts nexts;
  if (visits)
    tree.visit([&](const PartTree::Node& node) { return may_mirror(v, node); },
               [&](std::uint32_t part) {
                 nexts.clear();
                 add_next(v, root, parts_[part], nexts);
                 for (const Next& next : nexts)
                   visit(v, extended(root, next), number++, s, work, found, Lights::kWithPlace);
               });
  const bool all_visited = visits && std::ranges::find(has_target_, false) == has_target_.end();
  if (all_visited && !has_unsized_) return;
  const bool only_places = !v.is_receiver && paths_use_targets_;
  const auto may_choose = [&](const PartTree::Node& node) {
    return !only_places || may_mirror(v, node);
  };
  Sequence walk = root;
  do {
    const auto choice =
        tree.choose(walk.steps.empty() ? v.hit.position : walk.steps.back().part->middle,
                    choices.uniform(), may_choose);
    if (!choice) return;
    nexts.clear();
    add_next(v, walk, parts_[choice->part], nexts);
    if (nexts.empty()) return;
    double sum = 0;
    for (const Next& next : nexts) sum += next.share;
    const double u = choices.uniform() * sum;
    const Next& next = nexts.size() == 1 || u < nexts[0].share ? nexts[0] : nexts[1];
    const double survival = walk.steps.empty() ? 1 : std::clamp(sum, 0.25, 0.75);
    if (survival < 1 && choices.uniform() >= survival) return;
    const double weight = walk.weight * sum / (choice->probability * next.share * survival);
    walk = extended(walk, next);
    walk.weight = weight;
    const Lights which = walk.steps.size() > 1 ? Lights::kUnsized
                         : visits              ? Lights::kWithoutPlace
                                               : Lights::kAll;
    visit(v, walk, number++, s, work, found, which);
  } while (has_unsized_ && walk.steps.size() < std::min<std::size_t>(kMostSteps, v.most_steps));
}

}  // namespace lucerna
