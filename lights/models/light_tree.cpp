#include "lights/models/light_tree.h"

#include <absl/container/inlined_vector.h>

#include <algorithm>
#include <cmath>

namespace lucerna {
namespace {

// The smallest cosine of a node that may be visible.  A computed cosine may reach 0 a little too
// early, by rounding.
constexpr double kLeastCosine = 0x1p-20;
// Receivers see this far below their horizon, because their normals are rounded to floats.
constexpr double kHorizonRad = 0x1p-21;
// Farther receivers see the tree as a point.  The fourth power of this distance still fits a
// double.
constexpr double kFarthest = 0x1p240;
constexpr double kBelowOne = 1 - 0x1p-53;
// A node's weight is 1 / (d_near d_mid), with the distances to its nearest point and to its middle.
// For lights in a line or plane beside the receiver, this is closer to the mean of 1 / d^2 than 1 /
// d_mid^2.  A node that contains the receiver then has more weight than its neighbour.  The nearest
// distance is at least this share of the box's radius.
//
// Second moment of one sample over the squared mean, for shares of 1, 1/8, 1/16 and 1/32, and for
// the paper's squared distance:
//   street with 4096 lamps:          6.3, 1.9, 1.6,  1.4 and 3.5
//   ceiling with 4096 panels:         20, 3.4, 2.5,  2.2 and 13
//   4096 lamps in a cube:             13, 1.6, 1.5,  2.0 and 8.5
//   houses with 4096 windows:         41, 8.4, 8.6, 11.5 and 30
constexpr double kNearestShare = 1.0 / 16;

/// A vector of each child.
struct TwoVecs {
  TwoDoubles x, y, z;

  TwoVecs operator+(const TwoVecs& v) const { return {x + v.x, y + v.y, z + v.z}; }
  TwoVecs operator-(const TwoVecs& v) const { return {x - v.x, y - v.y, z - v.z}; }
  TwoVecs operator*(double s) const { return {x * s, y * s, z * s}; }
};

TwoVecs both_vecs(const Vec3& v) { return {both(v.x), both(v.y), both(v.z)}; }
template <typename T>
TwoVecs both_vecs(const T (&v)[3][2]) {
  return {both(v[0]), both(v[1]), both(v[2])};
}
TwoDoubles dot(const TwoVecs& a, const TwoVecs& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
TwoVecs cross(const TwoVecs& a, const TwoVecs& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Angles in [0, pi], stored as their cosines and sines, or as common multiples of both.
struct Turns {
  TwoDoubles cos, sin;
  Turns less(const Turns& other) const {
    return {cos * other.cos + sin * other.sin, sin * other.cos - cos * other.sin};
  }
};

/// Half the extents of the boxes along the unit vectors `w`.
TwoDoubles reach_along(const TwoVecs& w, const TwoVecs& half) {
  return abs(w.x) * half.x + abs(w.y) * half.y + abs(w.z) * half.z;
}

}  // namespace

std::optional<LightTree::Query> LightTree::query_from(const Receiver& receiver) const {
  if (empty() || !is_finite(receiver.position) || !is_finite(receiver.normal)) return std::nullopt;
  Query from{receiver.position * scale_, receiver.normal, receiver.normal != Vec3{}};
  if (max_abs(from.position) > kFarthest)
    from.position = scaled(receiver.position, -std::ilogb(max_abs(receiver.position))) * kFarthest;
  return from;
}

void LightTree::prefetch(std::uint32_t pair) const {
  __builtin_prefetch(&pairs_[pair]);
  if (!cones_.empty()) __builtin_prefetch(&cones_[pair]);
}

// Both children at once and without branches: random receivers would mispredict most of them.
TwoDoubles LightTree::importance(std::uint32_t pair, const Query& from) const {
  const Pair& node = pairs_[pair];
  const TwoVecs position = both_vecs(from.position);
  const TwoVecs to_lower = position - both_vecs(node.lower),
                to_upper = position - both_vecs(node.upper);
  const TwoVecs half = (to_lower - to_upper) * 0.5;
  const TwoVecs way = (to_lower + to_upper) * 0.5;  // from the box's middle to the receiver
  const TwoDoubles zero = both(0.0);
  const TwoDoubles r2 = dot(half, half), d2 = dot(way, way);
  const TwoDoubles r = sqrt(r2), d = sqrt(d2);
  // theta_u: the angle that the box covers, seen from the receiver; cosine and sine times d.
  // Within the box's sphere: all directions.
  const TwoMasks is_outside = d2 > r2;
  const Turns box{sqrt(is_outside ? d2 - r2 : zero), r};

  TwoMasks is_dark{};
  TwoDoubles cosines = both(1.0);
  if (from.has_normal) {
    const TwoVecs normal = both_vecs(from.normal);
    const TwoDoubles height = -dot(normal, way);
    is_dark = height + reach_along(normal, half) < -kHorizonRad * (d + r);
    const Turns above{height, sqrt(max(zero, d2 - height * height))};
    const Turns nearest = above.less(box);
    const TwoMasks is_slanted = is_outside & (nearest.sin > 0);
    cosines = is_slanted ? max(nearest.cos / d2, both(kLeastCosine)) : cosines;
  }

  const Child &left = node.child[0], &right = node.child[1];
  if ((left.has_cone | right.has_cone) != 0) {
    const auto mask = [](std::uint32_t l, std::uint32_t r) {
      return TwoMasks{-std::int64_t{l}, -std::int64_t{r}};
    };
    const TwoMasks has_cone = mask(left.has_cone, right.has_cone);
    const TwoMasks has_cosine = mask(left.has_cosine, right.has_cosine);
    const TwoMasks two_sided = mask(left.two_sided, right.two_sided);
    const Cones& cones = cones_[pair];
    const TwoVecs axis = both_vecs(cones.axis);
    const TwoDoubles along = dot(axis, way);
    const TwoVecs across = cross(axis, way);
    const Turns cone{both(cones.cos_o), both(cones.sin_o)};
    const Turns theta{two_sided ? abs(along) : along, sqrt(dot(across, across))};
    const Turns beyond_cone = theta.less(cone);
    const TwoMasks is_beyond = has_cone & (beyond_cone.sin > 0);
    const Turns nearest = beyond_cone.less(box);
    const TwoMasks is_box_beyond = is_beyond & is_outside & (nearest.sin > 0);
    is_dark |= is_box_beyond & ~(has_cosine & (nearest.cos > 0));
    cosines = is_box_beyond ? cosines * max(nearest.cos / d2, both(kLeastCosine)) : cosines;
    // The sphere of a flat box extends far in front of its plane and behind it.  So also test the
    // box along the axis: every point of it is at least this far ahead of the receiver, and at
    // most d + r away.
    is_dark |= is_beyond & has_cosine & ~two_sided & (cone.cos > 0) &
               (along + reach_along(axis, half) < -cone.sin * (d + r));
  }
  const TwoVecs beside{max(zero, abs(way.x) - half.x), max(zero, abs(way.y) - half.y),
                       max(zero, abs(way.z) - half.z)};
  const TwoDoubles nearest = max(sqrt(dot(beside, beside)), r * kNearestShare);
  const TwoDoubles importance = both(node.intensity) * cosines / (nearest * max(d, r));
  return is_dark ? zero : importance;
}

std::optional<LightChoice> LightTree::choose(const Receiver& receiver, double u) const {
  const std::optional<Query> from = query_from(receiver);
  if (!from) return std::nullopt;
  if (size() == 1) {
    if (!(importance(0, *from)[0] > 0)) return std::nullopt;
    return LightChoice{pairs_[0].child[0].index, 1};
  }
  double probability = 1;
  std::uint32_t pair = 0;
  while (true) {
    const Child(&child)[2] = pairs_[pair].child;
    // Both pairs of the next step are fetched while this step computes.
    for (const Child& next : child)
      if (next.is_leaf == 0) prefetch(next.index);
    const TwoDoubles both = importance(pair, *from);
    const double sum = both[0] + both[1];
    if (!(sum > 0)) return std::nullopt;
    const TwoDoubles shares = both / sum;
    // The rest of u chooses among the lights of the child.  If its bits are used up, the
    // probabilities are still valid.  No branch on the side, because u would mispredict it.
    const double share[] = {shares[0], shares[1]}, before[] = {0, shares[0]};
    const int side = u < share[0] ? 0 : 1;
    u = std::min((u - before[side]) / share[side], kBelowOne);
    probability *= share[side];
    const Child chosen = child[side];
    if (chosen.is_leaf != 0) return LightChoice{chosen.index, probability};
    pair = chosen.index;
  }
}

double LightTree::probability(const Receiver& receiver, std::uint32_t light) const {
  const std::optional<Query> from = query_from(receiver);
  if (!from || leaf_of_[light] == kNoLeaf) return 0;
  if (size() == 1) return importance(0, *from)[0] > 0 ? 1 : 0;
  // Shares from the leaf upwards.  The list grows as deep as the tree.
  absl::InlinedVector<double, 64> shares;
  for (NodeIndex at = leaf_of_[light];; at = parents_[at / 2]) {
    const std::uint32_t pair = at / 2;
    if (pair > 0) prefetch(parents_[pair] / 2);
    const TwoDoubles both = importance(pair, *from);
    const double l = both[0], r = both[1], own = at % 2 == 0 ? l : r;
    if (!(own > 0)) return 0;
    shares.push_back(own / (l + r));
    if (pair == 0) break;
  }
  // Multiplied as `choose` does, so that the bits are the same.
  double probability = 1;
  for (auto share = shares.rbegin(); share != shares.rend(); ++share) probability *= *share;
  return probability;
}

std::size_t LightTree::bytes() const {
  return pairs_.capacity() * sizeof(Pair) + cones_.capacity() * sizeof(Cones) +
         (parents_.capacity() + leaf_of_.capacity()) * sizeof(NodeIndex);
}

}  // namespace lucerna
