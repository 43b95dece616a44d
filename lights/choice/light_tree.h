// A bounding volume hierarchy over lights, by which a receiver chooses one of many in a few steps.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lights/models/light_bounds.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct LightCluster;

struct LightChoice {
  std::uint32_t light;
  double probability;
};

/// Chooses among lights by what each may give to a receiver: down a binary tree, at each node the
/// child of the greater importance with the greater probability.  Importance is power over the
/// solid angle it goes to, times bounds on the cosines at light and receiver, over the distances to
/// the nearest point of the box and to its middle.  [Conty18], which has power itself and the
/// squared distance to the middle; its splitting into several lights is left out.
///
/// Where light of a value above 0 arrives, importance is above 0: cones are 5e-7 rad wider than
/// they are told, boxes a few roundings.  Where it is 0, bounds prove that none arrives.  Scaling
/// all bounds and receivers by one power of two, and all powers by another, changes no bit.
///
/// Immutable, so safe to share between threads.
class LightTree {
 public:
  struct Item {
    LightBounds<double> bounds;
    double power;  ///< in any unit, of this light's share among all
  };
  static constexpr std::size_t kMaxLights = std::size_t{1} << 28;

  /// Lights of power 0 are left out, unless all are: then all count alike.  A power less than
  /// 2^-100 of the greatest counts as that.  Errors: more lights than kMaxLights; which item's
  /// bounds are not finite, or its power not finite or negative.
  static absl::StatusOr<LightTree> create(std::span<const Item> items);

  /// A light, by its place among the items, for `u` in [0, 1).  Nothing where no light of the node
  /// that was chosen last can reach the receiver, or it is not finite; that happens with the
  /// probability which those of all lights leave to 1.  Uses position and normal; with no normal
  /// (zero) light from all sides counts alike, else only what comes from above.
  std::optional<LightChoice> choose(const Receiver<double>& receiver, double u) const;
  /// The probability with which `choose` answers `light`, the same bits.
  double probability(const Receiver<double>& receiver, std::uint32_t light) const;

  /// Of lights that can be chosen.
  std::size_t size() const { return (nodes_.size() + 1) / 2; }
  bool empty() const { return nodes_.empty(); }
  std::size_t bytes() const;

 private:
  class Builder;

  /// A cache line.  Coordinates are the tree's own, in which the largest is about 1.
  struct alignas(64) Node {
    double axis[3];
    float lower[3], upper[3];
    float intensity;     ///< power over solid_angle_sr()
    float cos_o, sin_o;  ///< -1 and 0: all directions
    std::uint32_t is_leaf : 1, has_cosine : 1, two_sided : 1;
    std::uint32_t index : 29;  ///< of the left child, beside the right one; of a leaf's light
  };
  static_assert(sizeof(Node) == 64);

  /// A receiver in the tree's coordinates.
  struct Asking {
    Vec3<double> position, normal;
    bool has_normal;
  };

  static Node node_of(const LightCluster& cluster);
  std::optional<Asking> asking(const Receiver<double>& receiver) const;
  static double importance(const Node& node, const Asking& from);

  std::vector<Node> nodes_;             // the root, then pairs of siblings
  std::vector<std::uint32_t> parents_;  // of each pair
  std::vector<std::uint32_t> leaf_of_;  // of each item; kNoLeaf
  double scale_ = 1;                    // to the tree's coordinates, a power of two

  static constexpr std::uint32_t kNoLeaf = ~std::uint32_t{0};
};

}  // namespace lucerna
