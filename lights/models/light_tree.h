// A bounding volume hierarchy over lights: it chooses one of many lights for a receiver in a few
// steps.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lights/maths/two_doubles.h"
#include "lights/models/light_bounds.h"
#include "lights/models/light_choice.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct LightCluster;

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
    LightBounds bounds;
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
  std::optional<LightChoice> choose(const Receiver& receiver, double u) const;
  /// The probability with which `choose` returns `light`, with the same bits.
  double probability(const Receiver& receiver, std::uint32_t light) const;

  /// The number of lights that can be chosen.
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::size_t bytes() const;

 private:
  class Builder;

  /// A child of a pair.
  struct Child {
    std::uint32_t is_leaf : 1, has_cone : 1, has_cosine : 1, two_sided : 1;
    std::uint32_t index : 28;  ///< of the pair of its children; of a leaf's light
  };
  /// Both children of a node, in one cache line.  A step down reads no more if neither has a cone.
  /// Coordinates are the tree's own, with a largest value of about 1.
  struct alignas(64) Pair {
    float lower[3][2], upper[3][2];  ///< for each axis, of both children
    float intensity[2];              ///< power over solid_angle_sr()
    Child child[2];
  };
  static_assert(sizeof(Pair) == 64 && kMaxLights <= std::size_t{1} << 28);
  /// The directions of both children.
  struct alignas(64) Cones {
    double axis[3][2];
    float cos_o[2], sin_o[2];
  };
  static_assert(sizeof(Cones) == 64);

  /// A child by number: twice that of its pair, plus 1 for the right one.
  using NodeIndex = std::uint32_t;

  /// A receiver in the tree's coordinates.
  struct Query {
    Vec3 position, normal;
    bool has_normal;
  };

  void set(NodeIndex place, const LightCluster& cluster);
  std::optional<Query> query_from(const Receiver& receiver) const;
  /// Starts to load a pair into the cache.
  void prefetch(std::uint32_t pair) const;
  /// Of both children of a pair.
  TwoDoubles importance(std::uint32_t pair, const Query& from) const;

  std::vector<Pair> pairs_;   // the children of the root, then the left child's before the right's
  std::vector<Cones> cones_;  // of each pair; empty if all lights shine in all directions
  std::vector<NodeIndex> parents_;  // of each pair but the first
  std::vector<NodeIndex> leaf_of_;  // of each item; kNoLeaf
  std::size_t size_ = 0;            // a single light is the left child of the only pair
  double scale_ = 1;                // to the tree's coordinates, a power of two

  static constexpr NodeIndex kNoLeaf = ~NodeIndex{0};
};

}  // namespace lucerna
