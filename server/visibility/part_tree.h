// A tree over many smooth surfaces, for the few by way of which light may reach a point.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/visibility/smooth_part.h"

namespace lucerna {

/// Parts with their places and normals.  Immutable; may be called from any thread.
class PartTree {
 public:
  PartTree() = default;
  /// Of those parts that are not only nearly smooth.
  explicit PartTree(std::span<const SmoothPart> parts);

  struct Node {
    // A sphere that contains the parts [m].
    Vec3 middle;
    double radius_m = 0;
    // A cone that contains the normals of all parts, up to their signs.
    Vec3 axis;
    double angle_rad = 0;
    /// Whether light may leave a part in other ways than a flat mirror's.
    bool has_others = false;
    double weight = 0;       ///< of a choice: area times reflected share [m2]
    std::uint32_t size = 1;  ///< number of nodes from this one on, its children included
    std::uint32_t part = 0;  ///< of a leaf, whose size is 1

    /// The weight of a choice at a point.
    double weight_from(const Vec3& from) const;
    /// Whether a flat mirror of this node may send light from the sphere about `light` to `to`.
    /// It may if its normal halves the angle between both ways.
    bool may_mirror(const Vec3& to, const Vec3& light, double light_radius_m) const;
    /// The same for light from directions within an angle of `from`.
    bool may_mirror_from(const Vec3& to, const Vec3& from, double within_rad) const;
  };

  /// Calls `f(part)` for each part whose nodes `may(node)` holds for.
  template <typename May, typename F>
  void visit(const May& may, const F& f) const {
    for (std::uint32_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      const bool enters = may(node);
      if (enters && node.size == 1) f(node.part);
      i = enters ? i + 1 : i + node.size;
    }
  }

  struct Choice {
    std::uint32_t part;
    double probability;
  };
  /// A part whose nodes `may(node)` holds for, by its area, reflected share and distance from a
  /// point.  `u` in [0, 1).
  template <typename May>
  std::optional<Choice> choose(const Vec3& from, double u, const May& may) const {
    if (nodes_.empty()) return std::nullopt;
    double probability = 1;
    std::size_t i = 0;
    while (nodes_[i].size > 1) {
      const std::size_t first = i + 1, second = first + nodes_[first].size;
      const double a = may(nodes_[first]) ? nodes_[first].weight_from(from) : 0;
      const double b = may(nodes_[second]) ? nodes_[second].weight_from(from) : 0;
      if (!(a + b > 0) || !std::isfinite(a + b)) return std::nullopt;
      const double share = a / (a + b);
      const bool takes_first = u < share;
      probability *= takes_first ? share : 1 - share;
      u = takes_first ? u / share : (u - share) / (1 - share);
      i = takes_first ? first : second;
    }
    return Choice{nodes_[i].part, probability};
  }

  bool empty() const { return nodes_.empty(); }
  std::size_t bytes() const { return nodes_.capacity() * sizeof(Node); }

 private:
  void build(std::span<const SmoothPart> parts, std::span<std::uint32_t> numbers);

  std::vector<Node> nodes_;  // each before its first child, then its second
};

}  // namespace lucerna
