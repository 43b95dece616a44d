#include "server/scene/light_distribution.h"

#include <algorithm>

#include "lights/maths/stop_poll.h"

namespace lucerna {

LightDistribution::LightDistribution(std::span<const double> lumens) {
  constexpr double kEqualShare = 0.1;
  const double largest = lumens.empty() ? 0 : *std::ranges::max_element(lumens);
  double sum = 0;  // of powers divided by the largest, to avoid overflow
  double lit = 0;
  StopPoll poll;
  for (const double l : lumens) {
    poll();
    if (largest > 0) sum += l / largest;
    if (l > 0) lit += 1;
  }
  cumulative_.reserve(lumens.size());
  double running = 0;
  std::size_t last_lit = 0;
  for (std::size_t i = 0; i < lumens.size(); ++i, poll()) {
    if (largest <= 0)
      running = static_cast<double>(i + 1) / static_cast<double>(lumens.size());
    else if (lumens[i] > 0)
      running += (1 - kEqualShare) * (lumens[i] / largest / sum) + kEqualShare / lit;
    if (largest <= 0 || lumens[i] > 0) last_lit = i;
    cumulative_.push_back(running);
  }
  // By rounding, the running sum may not end at exactly 1.  The last light with power above 0 gets
  // the rest.
  for (std::size_t i = last_lit; i < cumulative_.size(); ++i) cumulative_[i] = 1;
}

LightChoice LightDistribution::choose(double u) const {
  auto at = std::ranges::upper_bound(cumulative_, u);
  if (at == cumulative_.end()) --at;
  const auto light = static_cast<std::uint32_t>(at - cumulative_.begin());
  return {light, probability(light)};
}

}  // namespace lucerna
