#include "server/scene/light_selector.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "lights/maths/stop_poll.h"

namespace lucerna {

LightSelector::LightSelector(std::vector<Item> items) {
  std::vector<double> all, lux, lumens;
  StopPoll poll;
  for (const Item& item : items) {
    poll();
    all.push_back(item.lumens);
    if (item.bounds) {
      local_.lights.push_back(item.light);
      lumens.push_back(item.lumens);
      items_.push_back({*item.bounds, item.lumens});
    } else {
      beside_.lights.push_back(item.light);
      lux.push_back(item.lux);
    }
  }
  by_flux_ = LightDistribution(all);
  beside_.distribution = LightDistribution(lux);
  local_.distribution = LightDistribution(lumens);
  const auto is_lit = [](const std::vector<double>& of) {
    return std::ranges::any_of(of, [](double v) { return v > 0; });
  };
  // Black lights are chosen only if all are black.
  if (is_lit(lux) == is_lit(lumens))
    beside_share_ = lux.empty() ? 0 : lumens.empty() ? 1 : 0.5;
  else
    beside_share_ = is_lit(lux) ? 1 : 0;
  if (automatic() != LightSelection::kBvh) return;
  tree();
  items_ = std::vector<LightTree::Item>();  // {} would keep its room
}

std::optional<std::uint32_t> LightSelector::Group::index_of(std::uint32_t light) const {
  const auto at = std::ranges::lower_bound(lights, light);
  if (at == lights.end() || *at != light) return std::nullopt;
  return static_cast<std::uint32_t>(at - lights.begin());
}

LightChoice LightSelector::Group::choose(double u) const {
  const LightChoice choice = distribution.choose(u);
  return {lights[choice.light], choice.probability};
}

const LightTree& LightSelector::tree() const {
  return tree_.get(
      // `create` cannot fail here: the numbers of a scene's lights are always valid.
      [this] { return std::make_unique<const LightTree>(LightTree::create(items_).value()); },
      [this](const LightTree&) {
        return items_.size() < kTreeFrom
                   ? fmt::format("{} local lights; a query selected the tree", items_.size())
                   : fmt::format("{} local lights, {} or more", items_.size(), kTreeFrom);
      });
}

LightSelection LightSelector::automatic() const {
  return local_.lights.size() >= kTreeFrom ? LightSelection::kBvh : LightSelection::kPower;
}

std::optional<LightChoice> LightSelector::choose(LightSelection how, const Receiver& receiver,
                                                 double u) const {
  if (how == LightSelection::kAutomatic) how = automatic();
  const std::size_t count = beside_.lights.size() + local_.lights.size();
  if (how == LightSelection::kUniform) {
    const auto n = static_cast<double>(count);
    const auto i = static_cast<std::size_t>(std::min(u * n, n - 1));
    return LightChoice{
        i < beside_.lights.size() ? beside_.lights[i] : local_.lights[i - beside_.lights.size()],
        1 / n};
  }
  if (u < beside_share_) {
    LightChoice choice = beside_.choose(u / beside_share_);
    choice.probability *= beside_share_;
    return choice;
  }
  const double share = 1 - beside_share_, v = std::min((u - beside_share_) / share, 1 - 0x1p-53);
  if (how == LightSelection::kPower) {
    LightChoice choice = local_.choose(v);
    choice.probability *= share;
    return choice;
  }
  std::optional<LightChoice> choice = tree().choose(receiver, v);
  if (choice) *choice = {local_.lights[choice->light], choice->probability * share};
  return choice;
}

double LightSelector::probability(LightSelection how, const Receiver& receiver,
                                  std::uint32_t light) const {
  if (how == LightSelection::kAutomatic) how = automatic();
  if (how == LightSelection::kUniform)
    return 1 / static_cast<double>(beside_.lights.size() + local_.lights.size());
  if (const auto index = beside_.index_of(light))
    return beside_.distribution.probability(*index) * beside_share_;
  const std::uint32_t index = *local_.index_of(light);
  const double share = 1 - beside_share_;
  return share * (how == LightSelection::kPower ? local_.distribution.probability(index)
                                                : tree().probability(receiver, index));
}

std::size_t LightSelector::bytes() const {
  std::size_t sum = by_flux_.bytes() + beside_.distribution.bytes() + local_.distribution.bytes();
  for (const Group* group : {&beside_, &local_})
    sum += group->lights.capacity() * sizeof(std::uint32_t);
  return sum + items_.capacity() * sizeof(LightTree::Item);
}

}  // namespace lucerna
