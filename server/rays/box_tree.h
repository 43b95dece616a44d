// A hierarchy of boxes.  It finds the items that may lie within a region without visiting all
// items.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

/// A box in floats that contains its item.
struct Boundsf {
  Vec3f lower, upper;

  /// Rounded outwards.
  static Boundsf around(const Vec3& lower, const Vec3& upper);
};

/// Immutable once built; may be called from any thread.
class BoxTree {
 public:
  BoxTree() = default;
  /// Item i has boxes[i].
  explicit BoxTree(std::span<const Boundsf> boxes);

  /// Whether `found(item)` is true for any item within boxes that `may_hold(box)` accepts.
  /// `may_hold` must accept each box that contains an accepted box.  All items of a small
  /// leaf are tested.
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

  /// The box of all items.  Requires at least one item.
  const Boundsf& box() const { return nodes_.front().box; }
  bool empty() const { return nodes_.empty(); }
  std::size_t bytes() const {
    return nodes_.capacity() * sizeof(Node) + order_.capacity() * sizeof(std::uint32_t);
  }

 private:
  /// Each split halves the number of items, so 2^32 items fit.
  static constexpr int kMostDepth = 33;

  struct Node {
    Boundsf box;
    std::uint32_t first;  ///< first of its items in `order_`; for an inner node, its second child
    std::uint32_t count;  ///< 0: an inner node, whose first child is the next node
  };

  void build(std::span<const Boundsf> boxes, std::uint32_t begin, std::uint32_t end);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

}  // namespace lucerna
