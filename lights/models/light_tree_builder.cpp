// Builds a light tree from the root down.  Each node's lights are put into bins along each axis and
// split where the surface area orientation heuristic gives the least cost. [Conty18, 4.4]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "lights/maths/stop_poll.h"
#include "lights/models/light_cluster.h"
#include "lights/models/light_tree.h"
#include "lights/shapes/shape.h"

namespace lucerna {
namespace {

// Cones in a tree are wider by this: half for the rounding of a node's cone to floats, half for the
// rounding of lights and receivers.
constexpr double kConeSlackRad = 0x1p-21;
// A cone that lacks less than this counts as all directions.
constexpr double kNearlyAllRad = 0x1p-10;
// Boxes are larger by the rounding of lights, relative to their coordinates, and by at least
// kLeastBox.  So squares of a box's size are never denormal numbers.
constexpr double kBoxSlack = 16 * std::numeric_limits<double>::epsilon();
constexpr double kLeastBox = 0x1p-100;
constexpr double kLeastPower = 0x1p-100;
constexpr int kMostBins = 16;

bool has_cone(const LightCluster& cluster) { return !(cluster.theta_o_rad > kPi - kNearlyAllRad); }

}  // namespace

class LightTree::Builder {
 public:
  explicit Builder(std::span<const Item> items) : items_(items) {}

  absl::Status check() const;
  LightTree build();

 private:
  /// Makes the tree below `place` from the lights order_[begin, end).
  struct Task {
    std::uint32_t begin, end;
    NodeIndex place;  ///< that of the root is not used
    LightCluster cluster;
  };
  struct Split {
    std::uint32_t middle;  ///< where order_ is split
    LightCluster left, right;
  };
  /// Puts lights into bins by their middles along an axis.
  struct Binning {
    int axis, count;
    double from, per_extent;

    int operator()(const LightCluster& light) const {
      const double at = (middle(light, axis) - from) * per_extent;
      return std::clamp(static_cast<int>(at), 0, count - 1);
    }
  };

  static double middle(const LightCluster& light, int axis) {
    return light.lower[axis] * 0.5 + light.upper[axis] * 0.5;
  }
  void take_lights(double scale);
  LightCluster cluster_of(std::span<const std::uint32_t> lights) const;
  /// Fills bins_; nothing where all lights are at one place of the axis.
  std::optional<Binning> fill_bins(int axis, const Task& task);
  Split split(const Task& task);
  Split split_in_half(const Task& task) const;

  std::span<const Item> items_;
  std::vector<LightCluster> lights_;  // of each item, in the tree's coordinates
  std::vector<std::uint32_t> order_;  // items that can be chosen; those of a node are contiguous
  std::array<LightCluster, kMostBins> bins_,
      after_;  // bins of an axis; sums from a bin to the last one
};

absl::Status LightTree::Builder::check() const {
  if (items_.size() > kMaxLights)
    return absl::ResourceExhaustedError(
        fmt::format("light tree of {} lights, allowed: up to {}", items_.size(), kMaxLights));
  StopPoll poll;
  for (std::size_t i = 0; i < items_.size(); ++i, poll()) {
    const LightBounds& b = items_[i].bounds;
    if (!is_finite(b.lower) || !is_finite(b.upper) || !is_finite(b.axis) ||
        !(b.cone_rad >= 0 && b.normals_rad >= 0))
      return absl::InvalidArgumentError(
          fmt::format("light tree: bounds of light {}, allowed: finite ones", i));
    if (!(items_[i].power >= 0) || !std::isfinite(items_[i].power))
      return absl::InvalidArgumentError(fmt::format(
          "light tree: power {} of light {}, allowed: finite, not negative", items_[i].power, i));
  }
  return absl::OkStatus();
}

void LightTree::Builder::take_lights(double scale) {
  double most = 0;
  StopPoll poll;
  for (const Item& item : items_) poll(), most = std::max(most, item.power);
  const bool all_black = !(most > 0);
  const int exponent = all_black ? 0 : -std::ilogb(most);
  lights_.resize(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i, poll()) {
    if (!all_black && !(items_[i].power > 0)) continue;
    order_.push_back(static_cast<std::uint32_t>(i));
    const LightBounds& b = items_[i].bounds;
    LightCluster& light = lights_[i];
    const Vec3 lower = b.lower * scale, upper = b.upper * scale;
    const double pad = std::max(kBoxSlack * std::max(max_abs(lower), max_abs(upper)), kLeastBox);
    light.lower = lower - Vec3{pad, pad, pad};
    light.upper = upper + Vec3{pad, pad, pad};
    light.axis = normalized(b.axis);
    light.has_cosine = b.two_sided || b.normals_rad < b.cone_rad;
    light.two_sided = b.two_sided;
    // With a cosine, emission covers the hemisphere about a normal, so subtract it from the cone.
    const double theta_o = b.two_sided        ? b.normals_rad
                           : light.has_cosine ? std::max(b.normals_rad, b.cone_rad - kPi / 2)
                                              : b.cone_rad;
    const double all = b.two_sided ? kPi / 2 : kPi;
    light.theta_o_rad = theta_o + kConeSlackRad;
    if (light.theta_o_rad > all - kNearlyAllRad || light.axis == Vec3{}) light.theta_o_rad = kPi;
    light.power = all_black ? 1 : std::max(std::scalbn(items_[i].power, exponent), kLeastPower);
  }
}

LightCluster LightTree::Builder::cluster_of(std::span<const std::uint32_t> lights) const {
  LightCluster all;
  StopPoll poll;
  for (const std::uint32_t i : lights) poll(), all.add(lights_[i]);
  return all;
}

void LightTree::set(NodeIndex place, const LightCluster& cluster) {
  Pair& pair = pairs_[place / 2];
  const int side = static_cast<int>(place % 2);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    pair.lower[axis][side] = std::nextafter(static_cast<float>(cluster.lower[axis]), -kInfinity);
    pair.upper[axis][side] = std::nextafter(static_cast<float>(cluster.upper[axis]), kInfinity);
  }
  pair.intensity[side] = static_cast<float>(cluster.power / cluster.solid_angle_sr());
  Child& child = pair.child[side];
  child.has_cosine = cluster.has_cosine ? 1 : 0;
  child.two_sided = cluster.two_sided ? 1 : 0;
  child.has_cone = has_cone(cluster) ? 1 : 0;
  if (child.has_cone == 0) return;
  Cones& cones = cones_[place / 2];
  for (int axis = 0; axis < 3; ++axis) cones.axis[axis][side] = cluster.axis[axis];
  cones.cos_o[side] = static_cast<float>(std::cos(cluster.theta_o_rad));
  cones.sin_o[side] = static_cast<float>(std::sin(cluster.theta_o_rad));
}

std::optional<LightTree::Builder::Binning> LightTree::Builder::fill_bins(int axis,
                                                                         const Task& task) {
  double from = LightCluster::kInfinity, to = -from;
  StopPoll poll;
  for (std::uint32_t i = task.begin; i < task.end; ++i, poll()) {
    const double at = middle(lights_[order_[i]], axis);
    from = std::min(from, at);
    to = std::max(to, at);
  }
  // Lights closer together than the least box count as at one place.
  if (!(to - from > kLeastBox)) return std::nullopt;
  const int count = static_cast<int>(std::min<std::uint32_t>(kMostBins, task.end - task.begin));
  const Binning bin_of{axis, count, from, count / (to - from)};
  std::fill_n(bins_.begin(), count, LightCluster{});
  for (std::uint32_t i = task.begin; i < task.end; ++i, poll()) {
    const LightCluster& light = lights_[order_[i]];
    bins_[bin_of(light)].add(light);
  }
  return bin_of;
}

LightTree::Builder::Split LightTree::Builder::split_in_half(const Task& task) const {
  const std::uint32_t middle = task.begin + (task.end - task.begin) / 2;
  const std::span<const std::uint32_t> order(order_);
  return {middle, cluster_of(order.subspan(task.begin, middle - task.begin)),
          cluster_of(order.subspan(middle, task.end - middle))};
}

LightTree::Builder::Split LightTree::Builder::split(const Task& task) {
  if (task.end - task.begin == 2) return split_in_half(task);
  const Vec3 extent = task.cluster.upper - task.cluster.lower;
  double least = LightCluster::kInfinity;
  Binning best{};
  int first_right = 0;
  Split found{};
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<Binning> bin_of = fill_bins(axis, task);
    if (!bin_of) continue;
    const int last = bin_of->count - 1;
    after_[last] = bins_[last];
    for (int i = last - 1; i > 0; --i) {
      after_[i] = after_[i + 1];
      after_[i].add(bins_[i]);
    }
    // Prefer splits across the longest side, which avoid thin slices.
    const double across = max_abs(extent) / extent[axis];
    LightCluster before;
    for (int i = 1; i <= last; ++i) {
      before.add(bins_[i - 1]);
      const double cost = across * (before.cost() + after_[i].cost());
      if (!(cost < least)) continue;
      least = cost;
      best = *bin_of;
      first_right = i;
      found.left = before;
      found.right = after_[i];
    }
  }
  // All at one place: no part is better than another.
  if (first_right == 0) return split_in_half(task);
  const auto first = order_.begin();
  const auto middle =
      std::partition(first + task.begin, first + task.end,
                     [&](std::uint32_t light) { return best(lights_[light]) < first_right; });
  found.middle = static_cast<std::uint32_t>(middle - first);
  return found;
}

LightTree LightTree::Builder::build() {
  LightTree tree;
  double largest = 0;
  for (const Item& item : items_)
    largest = std::max({largest, max_abs(item.bounds.lower), max_abs(item.bounds.upper)});
  if (largest > 0) tree.scale_ = std::scalbn(1.0, std::clamp(-std::ilogb(largest), -500, 500));
  take_lights(tree.scale_);
  tree.leaf_of_.assign(items_.size(), kNoLeaf);
  if (order_.empty()) return tree;
  tree.size_ = order_.size();
  const std::size_t pairs = std::max<std::size_t>(1, order_.size() - 1);
  tree.pairs_.reserve(pairs);
  tree.parents_.reserve(pairs);
  if (std::ranges::any_of(order_, [&](std::uint32_t i) { return has_cone(lights_[i]); }))
    tree.cones_.resize(pairs);
  const LightCluster all = cluster_of(order_);
  if (order_.size() == 1) {
    tree.pairs_.emplace_back();
    tree.set(0, all);
  }
  // An explicit stack: lights in a line make the tree too deep for recursive calls.
  std::vector<Task> tasks;
  tasks.push_back({0, static_cast<std::uint32_t>(order_.size()), 0, all});
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    if (task.end - task.begin == 1) {
      const std::uint32_t light = order_[task.begin];
      Child& leaf = tree.pairs_[task.place / 2].child[task.place % 2];
      leaf.is_leaf = 1;
      leaf.index = light;
      tree.leaf_of_[light] = task.place;
      continue;
    }
    const Split parts = split(task);
    const auto pair = static_cast<std::uint32_t>(tree.pairs_.size());
    if (pair > 0) tree.pairs_[task.place / 2].child[task.place % 2].index = pair;
    tree.pairs_.emplace_back();
    tree.parents_.push_back(task.place);
    tree.set(2 * pair, parts.left);
    tree.set(2 * pair + 1, parts.right);
    tasks.push_back({parts.middle, task.end, 2 * pair + 1, parts.right});
    tasks.push_back({task.begin, parts.middle, 2 * pair, parts.left});
  }
  return tree;
}

absl::StatusOr<LightTree> LightTree::create(std::span<const Item> items) {
  Builder builder(items);
  if (absl::Status s = builder.check(); !s.ok()) return s;
  return builder.build();
}

}  // namespace lucerna
