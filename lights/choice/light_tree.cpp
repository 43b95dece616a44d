#include "lights/choice/light_tree.h"

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

Vec3<double> vec(const float (&v)[3]) { return {double{v[0]}, double{v[1]}, double{v[2]}}; }

/// An angle in [0, pi], stored as its cosine and sine, or as a common multiple of both.
struct Turn {
  double cos, sin;
  Turn less(const Turn& other) const {
    return {cos * other.cos + sin * other.sin, sin * other.cos - cos * other.sin};
  }
};

/// Half the extent of the box along the unit vector `w`.
double reach_along(const Vec3<double>& w, const Vec3<double>& half) {
  return std::fabs(w.x) * half.x + std::fabs(w.y) * half.y + std::fabs(w.z) * half.z;
}

}  // namespace

std::optional<LightTree::Query> LightTree::query_from(const Receiver<double>& receiver) const {
  if (nodes_.empty() || !is_finite(receiver.position) || !is_finite(receiver.normal))
    return std::nullopt;
  Query from{receiver.position * scale_, receiver.normal, receiver.normal != Vec3<double>{}};
  if (max_abs(from.position) > kFarthest)
    from.position = scaled(receiver.position, -std::ilogb(max_abs(receiver.position))) * kFarthest;
  return from;
}

double LightTree::importance(const Node& node, const Query& from) {
  const Vec3<double> to_lower = from.position - vec(node.lower);
  const Vec3<double> to_upper = from.position - vec(node.upper);
  const Vec3<double> half = (to_lower - to_upper) * 0.5;
  const Vec3<double> way = (to_lower + to_upper) * 0.5;  // from the box's middle to the receiver
  const double r2 = dot(half, half), d2 = dot(way, way);
  const double r = std::sqrt(r2), d = std::sqrt(d2);
  // theta_u: the angle that the box covers, seen from the receiver; cosine and sine times d.
  // Within the box's sphere: all directions.
  const bool is_outside = d2 > r2;
  const Turn box{is_outside ? std::sqrt(d2 - r2) : 0, r};

  double cosines = 1;
  if (from.has_normal) {
    const double height = -dot(from.normal, way);
    if (height + reach_along(from.normal, half) < -kHorizonRad * (d + r)) return 0;
    if (is_outside) {
      const Turn above{height, std::sqrt(std::max(0.0, d2 - height * height))};
      const Turn nearest = above.less(box);
      if (nearest.sin > 0) cosines = std::max(nearest.cos / d2, kLeastCosine);
    }
  }

  if (node.cos_o > -1) {
    const Vec3<double> axis{node.axis[0], node.axis[1], node.axis[2]};
    const double along = dot(axis, way);
    const Vec3<double> across = cross(axis, way);
    const Turn cone{double{node.cos_o}, double{node.sin_o}};
    const Turn theta{node.two_sided != 0 ? std::fabs(along) : along,
                     std::sqrt(dot(across, across))};
    const Turn beyond_cone = theta.less(cone);
    if (beyond_cone.sin > 0) {
      if (is_outside) {
        const Turn nearest = beyond_cone.less(box);
        if (nearest.sin > 0) {
          if (node.has_cosine == 0 || !(nearest.cos > 0)) return 0;
          cosines *= std::max(nearest.cos / d2, kLeastCosine);
        }
      }
      // The sphere of a flat box extends far in front of its plane and behind it.  So also test the
      // box along the axis: every point of it is at least this far ahead of the receiver, and at
      // most d + r away.
      if (node.has_cosine != 0 && node.two_sided == 0 && cone.cos > 0 &&
          along + reach_along(axis, half) < -cone.sin * (d + r))
        return 0;
    }
  }
  const Vec3<double> beside{std::max(0.0, std::fabs(way.x) - half.x),
                            std::max(0.0, std::fabs(way.y) - half.y),
                            std::max(0.0, std::fabs(way.z) - half.z)};
  const double nearest = std::max(std::sqrt(dot(beside, beside)), r * kNearestShare);
  return double{node.intensity} * cosines / (nearest * std::max(d, r));
}

std::optional<LightChoice> LightTree::choose(const Receiver<double>& receiver, double u) const {
  const std::optional<Query> from = query_from(receiver);
  if (!from) return std::nullopt;
  const Node* node = nodes_.data();
  if (node->is_leaf != 0 && !(importance(*node, *from) > 0)) return std::nullopt;
  double probability = 1;
  while (node->is_leaf == 0) {
    const Node* left = &nodes_[node->index];
    const double l = importance(left[0], *from), r = importance(left[1], *from);
    const double sum = l + r;
    if (!(sum > 0)) return std::nullopt;
    // The rest of u chooses among the lights of the child.  If its bits are used up, the
    // probabilities are still valid.
    if (u < l / sum) {
      node = left;
      u = std::min(u / (l / sum), kBelowOne);
      probability *= l / sum;
    } else {
      node = left + 1;
      u = std::min((u - l / sum) / (r / sum), kBelowOne);
      probability *= r / sum;
    }
  }
  return LightChoice{node->index, probability};
}

double LightTree::probability(const Receiver<double>& receiver, std::uint32_t light) const {
  const std::optional<Query> from = query_from(receiver);
  if (!from || leaf_of_[light] == kNoLeaf) return 0;
  std::uint32_t at = leaf_of_[light];
  if (at == 0) return importance(nodes_[0], *from) > 0 ? 1 : 0;
  // Shares from the leaf upwards.  The list grows as deep as the tree.
  absl::InlinedVector<double, 64> shares;
  while (at > 0) {
    const std::uint32_t left = at - (at % 2 == 0 ? 1 : 0);
    const double l = importance(nodes_[left], *from), r = importance(nodes_[left + 1], *from);
    const double own = at == left ? l : r;
    if (!(own > 0)) return 0;
    shares.push_back(own / (l + r));
    at = parents_[left / 2];
  }
  // Multiplied as `choose` does, so that the bits are the same.
  double probability = 1;
  for (auto share = shares.rbegin(); share != shares.rend(); ++share) probability *= *share;
  return probability;
}

std::size_t LightTree::bytes() const {
  return nodes_.capacity() * sizeof(Node) + parents_.capacity() * sizeof parents_[0] +
         leaf_of_.capacity() * sizeof leaf_of_[0];
}

}  // namespace lucerna
