// A hierarchy of boxes: what may lie within a region is found without looking at the rest.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

/// A box in floats, not smaller than what it is about.
struct FloatBox {
  Vec3<float> lower, upper;

  /// Rounded outwards.
  static FloatBox around(const Vec3<double>& lower, const Vec3<double>& upper);
};

/// Immutable once built; safe to share between threads.
class BoxTree {
 public:
  BoxTree() = default;
  /// Of items numbered as their boxes are.
  explicit BoxTree(std::span<const FloatBox> boxes);

  /// Whether `found(item)` says so of any item within boxes that `may_hold(box)` accepts, which
  /// accepts whatever holds a box that it accepts.  Items within a box of few are all asked about.
  template <typename MayHold, typename Found>
  bool any(const MayHold& may_hold, const Found& found) const {
    if (nodes_.empty()) return false;
    std::array<std::uint32_t, kMostDepth> waiting;
    int count = 0;
    for (std::uint32_t at = 0;;) {
      const Node& node = nodes_[at];
      if (may_hold(node.box)) {
        if (node.count == 0) {
          waiting[count++] = node.first;
          ++at;
          continue;
        }
        for (std::uint32_t i = 0; i < node.count; ++i)
          if (found(order_[node.first + i])) return true;
      }
      if (count == 0) return false;
      at = waiting[--count];
    }
  }

  /// Of all items; meaningless where there are none.
  const FloatBox& box() const { return nodes_.front().box; }
  bool empty() const { return nodes_.empty(); }
  std::size_t bytes() const {
    return nodes_.capacity() * sizeof(Node) + order_.capacity() * sizeof(std::uint32_t);
  }

 private:
  /// Each split halves the number of items: 2^32 of them are no deeper.
  static constexpr int kMostDepth = 33;

  struct Node {
    FloatBox box;
    std::uint32_t first;  ///< of its items in `order_`; of an inner node its second child
    std::uint32_t count;  ///< 0: an inner node, its first child the next node
  };

  void build(std::span<const FloatBox> boxes, std::uint32_t begin, std::uint32_t end);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

}  // namespace lucerna
