#include "client/lab/partition.h"

#include <algorithm>
#include <limits>

namespace lucerna::verify {
namespace {

constexpr double kWeightOfReceivers = 0.25;

}  // namespace

Partition::Partition(const std::vector<Feature>& reference, std::size_t cells)
    : total_(reference.size()) {
  std::array<double, 6> lower, upper;
  lower.fill(std::numeric_limits<double>::infinity());
  upper.fill(-std::numeric_limits<double>::infinity());
  for (const Feature& f : reference) {
    for (std::size_t i = 0; i < 6; ++i) {
      lower[i] = std::min(lower[i], f[i]);
      upper[i] = std::max(upper[i], f[i]);
    }
  }
  double directions = 0, receivers = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    directions = std::max(directions, upper[i] - lower[i]);
    receivers = std::max(receivers, upper[i + 3] - lower[i + 3]);
  }
  // Errors of sampling show in directions more than in receivers.
  for (std::size_t i = 0; i < 3; ++i) {
    scale_[i] = 1;
    scale_[i + 3] = receivers > 0 ? kWeightOfReceivers * directions / receivers : 0;
  }
  std::vector<Feature> all = reference;
  build(all, 0, all.size(), std::max<std::size_t>(1, cells));
}

std::size_t Partition::build(std::vector<Feature>& all, std::size_t begin, std::size_t end,
                             std::size_t want) {
  const std::size_t here = nodes_.size();
  nodes_.emplace_back();
  if (want > 1) {
    int widest = -1;
    double spread = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      const auto [lower, upper] = std::minmax_element(
          all.begin() + static_cast<long>(begin), all.begin() + static_cast<long>(end),
          [&](const Feature& a, const Feature& b) { return a[i] < b[i]; });
      const double width = scale_[i] * ((*upper)[i] - (*lower)[i]);
      if (width > spread) {
        spread = width;
        widest = static_cast<int>(i);
      }
    }
    if (widest >= 0) {
      const auto coordinate = static_cast<std::size_t>(widest);
      const auto less = [&](const Feature& a, const Feature& b) {
        return a[coordinate] < b[coordinate];
      };
      const std::size_t middle = begin + (end - begin) / 2;
      std::nth_element(all.begin() + static_cast<long>(begin),
                       all.begin() + static_cast<long>(middle),
                       all.begin() + static_cast<long>(end), less);
      // The cut is at a sample's own coordinate, so samples that coincide stay together.  If none
      // is smaller, the cut is at the next larger one.
      double below = all[middle][coordinate];
      double smallest = below, larger = std::numeric_limits<double>::infinity();
      for (std::size_t i = begin; i < end; ++i) {
        const double c = all[i][coordinate];
        smallest = std::min(smallest, c);
        if (c > below) larger = std::min(larger, c);
      }
      if (smallest == below) below = larger;
      const auto cut = std::partition(all.begin() + static_cast<long>(begin),
                                      all.begin() + static_cast<long>(end),
                                      [&](const Feature& f) { return f[coordinate] < below; });
      const auto at = static_cast<std::size_t>(cut - all.begin());
      if (at > begin && at < end) {
        const std::size_t left = build(all, begin, at, want / 2);
        const std::size_t right = build(all, at, end, want - want / 2);
        nodes_[here] = {widest, below, left, right, 0};
        return here;
      }
    }
  }
  nodes_[here].leaf = cells_++;
  probabilities_.push_back(static_cast<double>(end - begin) / static_cast<double>(total_));
  return here;
}

std::size_t Partition::cell(const Feature& f) const {
  std::size_t at = 0;
  while (nodes_[at].coordinate >= 0)
    at = f[static_cast<std::size_t>(nodes_[at].coordinate)] < nodes_[at].below ? nodes_[at].left
                                                                               : nodes_[at].right;
  return nodes_[at].leaf;
}

}  // namespace lucerna::verify
