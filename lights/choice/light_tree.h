// A bounding volume hierarchy over lights: it chooses one of many lights for a receiver in a few
// steps.
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

/// Chooses among lights by bounds on their contribution to a receiver. It walks down a binary tree,
/// and at each node the more important child has the greater probability.  Importance is I c / (d1
/// d2).  I is power over the solid angle of emission, and c the product of bounds on the cosines at
/// light and receiver.  d1 and d2 are the distances to the nearest point of the box and to its
/// middle. [Conty18] uses the power itself and the squared distance to the middle.  Its splitting
/// into several lights is not implemented.
///
/// Where importance is 0, the bounds prove that no light arrives.  For this, cones are 5e-7 rad
/// wider than given, and boxes a few roundings larger.  Scaling all bounds and receivers by one
/// power of two, and all powers by another, does not change a bit of the results.
///
/// Immutable, so safe to share between threads.
class LightTree {
 public:
  struct Item {
    LightBounds<double> bounds;
    double power;  ///< in any unit; its share of the sum weights this light
  };
  static constexpr std::size_t kMaxLights = std::size_t{1} << 28;

  /// Lights of power 0 are left out, unless all powers are 0: then all lights count equally.
  /// Powers below 2^-100 of the largest are raised to that.  Errors: more lights than kMaxLights;
  /// an item whose bounds or power are not finite, or whose power is negative.  The message has its
  /// number.
  static absl::StatusOr<LightTree> create(std::span<const Item> items);

  /// A light, by its index among the items, for `u` in [0, 1).  Nothing where no light of the last
  /// chosen node can reach the receiver, or where the receiver is not finite.  Choosing nothing has
  /// the probability 1 minus the sum over all lights.  Uses position and normal.  Without a normal
  /// (zero), light from all sides counts; with a normal, only light from above.
  std::optional<LightChoice> choose(const Receiver<double>& receiver, double u) const;
  /// The probability with which `choose` returns `light`, with the same bits.
  double probability(const Receiver<double>& receiver, std::uint32_t light) const;

  /// The number of lights that can be chosen.
  std::size_t size() const { return (nodes_.size() + 1) / 2; }
  bool empty() const { return nodes_.empty(); }
  std::size_t bytes() const;

 private:
  class Builder;

  /// A cache line.  Coordinates are the tree's own, with a largest value of about 1.
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
  struct Query {
    Vec3<double> position, normal;
    bool has_normal;
  };

  static Node node_of(const LightCluster& cluster);
  std::optional<Query> query_from(const Receiver<double>& receiver) const;
  static double importance(const Node& node, const Query& from);

  std::vector<Node> nodes_;             // the root, then pairs of siblings
  std::vector<std::uint32_t> parents_;  // of each pair
  std::vector<std::uint32_t> leaf_of_;  // of each item; kNoLeaf
  double scale_ = 1;                    // to the tree's coordinates, a power of two

  static constexpr std::uint32_t kNoLeaf = ~std::uint32_t{0};
};

}  // namespace lucerna
