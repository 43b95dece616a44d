#include "server/visibility/part_tree.h"

#include <algorithm>
#include <cmath>

#include "lights/maths/stop_poll.h"
#include "server/rays/surface_table.h"

namespace lucerna {
namespace {

double radius_of(const SmoothPart& part) {
  return part.is_sphere ? part.radius_m : length(part.half_u) + length(part.half_v);
}

double weight_of(const SmoothPart& part) {
  // Grazing light is reflected even by parts that reflect little along their normals.
  constexpr double kLeastShare = 0.05;
  const double area = part.is_sphere ? part.radius_m * part.radius_m
                                     : 4 * length(part.half_u) * length(part.half_v);
  return area * std::max(part.reflected, kLeastShare);
}

/// Whether a normal of the node may halve the angle between two directions, each of which may be
/// off by an angle.
bool may_halve(const PartTree::Node& node, const Vec3& a, double a_off_rad, const Vec3& b,
               double b_off_rad) {
  const Vec3 half = a + b;
  // A change of both directions by the angles turns their sum by at most this.
  const double turned = (a_off_rad + b_off_rad) / length(half);
  if (!(turned < 1)) return true;
  constexpr double kMargin = 1e-6;
  const double off = std::acos(std::fmin(1, std::fabs(dot(node.axis, normalized(half)))));
  return off <= node.angle_rad + std::asin(turned) + kMargin;
}

/// The angle that a sphere covers from its middle; beyond pi if the point is in it.
double half_angle(double radius_m, double distance_m) {
  return radius_m < distance_m ? std::asin(radius_m / distance_m) : 4;
}

}  // namespace

double PartTree::Node::weight_from(const Vec3& from) const {
  const Vec3 to = middle - from;
  return weight / std::fmax(dot(to, to), radius_m * radius_m);
}

bool PartTree::Node::may_mirror(const Vec3& to, const Vec3& light, double light_radius_m) const {
  if (has_others) return true;
  const Vec3 a = to - middle, b = light - middle;
  const double a_m = length(a), b_m = length(b);
  const double a_off = half_angle(radius_m, a_m),
               b_off = half_angle(radius_m + light_radius_m, b_m);
  if (a_off > kPi || b_off > kPi) return true;
  return may_halve(*this, a / a_m, a_off, b / b_m, b_off);
}

bool PartTree::Node::may_mirror_from(const Vec3& to, const Vec3& from, double within_rad) const {
  if (has_others) return true;
  const Vec3 a = to - middle;
  const double a_m = length(a), a_off = half_angle(radius_m, a_m);
  return a_off > kPi || may_halve(*this, a / a_m, a_off, from, within_rad);
}

PartTree::PartTree(std::span<const SmoothPart> parts) {
  std::vector<std::uint32_t> numbers;
  StopPoll poll;
  for (std::uint32_t i = 0; i < parts.size(); ++i, poll())
    if (parts[i].reflects || parts[i].refracts) numbers.push_back(i);
  nodes_.reserve(2 * numbers.size());
  if (!numbers.empty()) build(parts, numbers);
}

void PartTree::build(std::span<const SmoothPart> parts, std::span<std::uint32_t> numbers) {
  const std::size_t at = nodes_.size();
  Node node;
  Bounds middles;
  Vec3 sum{};
  StopPoll poll;
  for (const std::uint32_t i : numbers) {
    poll();
    const SmoothPart& part = parts[i];
    middles.add(part.middle);
    node.weight += weight_of(part);
    node.has_others |= part.is_sphere || part.refracts;
    sum += dot(sum, part.n) < 0 ? -part.n : part.n;
  }
  node.middle = middles.lower * 0.5 + middles.upper * 0.5;
  node.axis = length(sum) > 0 ? normalized(sum) : Vec3{0, 0, 1};
  for (const std::uint32_t i : numbers) {
    poll();
    const SmoothPart& part = parts[i];
    node.radius_m = std::fmax(node.radius_m, length(part.middle - node.middle) + radius_of(part));
    node.angle_rad =
        std::fmax(node.angle_rad, std::acos(std::fmin(1, std::fabs(dot(part.n, node.axis)))));
  }
  node.part = numbers[0];
  nodes_.push_back(node);
  if (numbers.size() == 1) return;
  const Vec3 size = middles.upper - middles.lower;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto place = [&](std::uint32_t i) {
    const Vec3& p = parts[i].middle;
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  };
  const std::size_t half = numbers.size() / 2;
  std::ranges::nth_element(numbers, numbers.begin() + static_cast<std::ptrdiff_t>(half), {}, place);
  build(parts, numbers.first(half));
  build(parts, numbers.subspan(half));
  nodes_[at].size = static_cast<std::uint32_t>(nodes_.size() - at);
}

}  // namespace lucerna
