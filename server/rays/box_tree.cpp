#include "server/rays/box_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kMostInLeaf = 4;

Vec3f smaller(const Vec3f& a, const Vec3f& b) {
  return {std::fmin(a.x, b.x), std::fmin(a.y, b.y), std::fmin(a.z, b.z)};
}
Vec3f larger(const Vec3f& a, const Vec3f& b) {
  return {std::fmax(a.x, b.x), std::fmax(a.y, b.y), std::fmax(a.z, b.z)};
}

}  // namespace

Boundsf Boundsf::around(const Vec3& lower, const Vec3& upper) {
  const auto down = [](double v) { return std::nextafter(static_cast<float>(v), -INFINITY); };
  const auto up = [](double v) { return std::nextafter(static_cast<float>(v), INFINITY); };
  return {{down(lower.x), down(lower.y), down(lower.z)}, {up(upper.x), up(upper.y), up(upper.z)}};
}

BoxTree::BoxTree(std::span<const Boundsf> boxes) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  if (!boxes.empty()) build(boxes, 0, static_cast<std::uint32_t>(boxes.size()));
  nodes_.shrink_to_fit();
}

void BoxTree::build(std::span<const Boundsf> boxes, std::uint32_t begin, std::uint32_t end) {
  const std::size_t self = nodes_.size();
  Boundsf box = boxes[order_[begin]];
  // The centre is half the sum of both corners.  They are halved first, so that large floats do not
  // overflow.
  const auto middle = [&](std::uint32_t item) {
    return boxes[item].lower * 0.5F + boxes[item].upper * 0.5F;
  };
  Vec3f first = middle(order_[begin]), last = first;
  StopPoll poll;
  for (std::uint32_t i = begin + 1; i < end; ++i, poll()) {
    const Boundsf& b = boxes[order_[i]];
    box = {smaller(box.lower, b.lower), larger(box.upper, b.upper)};
    first = smaller(first, middle(order_[i])), last = larger(last, middle(order_[i]));
  }
  nodes_.push_back({box, begin, end - begin});
  if (end - begin <= kMostInLeaf) return;
  const Vec3f extent = last - first;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(
      order_.begin() + begin, order_.begin() + half, order_.begin() + end,
      [&](std::uint32_t a, std::uint32_t b) { return middle(a)[axis] < middle(b)[axis]; });
  nodes_[self].count = 0;
  build(boxes, begin, half);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, half, end);
}

}  // namespace lucerna
