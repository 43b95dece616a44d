// The primitives that rays may meet, and points on them.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "tests/server/extremes/exact_rays.h"

namespace lucerna::testing {

void ExactGeometry::triangle(const Point& a, const Point& b, const Point& c) {
  Primitive p{.kind = Kind::kTriangle, .at = {a, b, c, {}}};
  const Point n = cross(b - a, c - a);
  p.normal = normalized(n);
  const double ab = length(b - a), bc = length(c - b), ca = length(a - c);
  // The same bound as in server/scene/scene_hit.cpp: the plane of a needle is known less well.
  const double longest = std::max({ab, bc, ca});
  p.slack = std::clamp(ab * bc * ca / longest / length(n), 1.0, 16.0);
  p.shortest = std::min({ab, bc, ca});
  add(p, (a + b + c) / 3.0, longest);
}

void ExactGeometry::sphere(const Point& centre, double radius) {
  add({.kind = Kind::kSphere, .at = {centre, {}, {}, {}}, .radius = radius}, centre, radius);
}

void ExactGeometry::disk(const Point& centre, const Point& normal, double radius) {
  add({.kind = Kind::kDisk, .at = {centre, {}, {}, {}}, .normal = normal, .radius = radius}, centre,
      radius);
}

void ExactGeometry::cylinder(const Point& centre, const Point& axis, double radius,
                             double half_height) {
  add({.kind = Kind::kCylinder,
       .at = {centre, {}, {}, {}},
       .normal = axis,
       .radius = radius,
       .half_height = half_height},
      centre, std::hypot(radius, half_height));
}

void ExactGeometry::patch(const Point& p00, const Point& p10, const Point& p01, const Point& p11) {
  Primitive p{.kind = Kind::kPatch, .at = {p00, p10, p01, p11}};
  p.shortest =
      std::min({length(p10 - p00), length(p01 - p00), length(p11 - p01), length(p11 - p10)});
  const Point centre = (p00 + p10 + p01 + p11) / 4.0;
  double reach = 0;
  for (const Point& c : p.at) reach = std::max(reach, length(c - centre));
  add(p, centre, reach);
}

void ExactGeometry::finish() {
  using Key = std::tuple<double, double, double>;
  const auto key = [](const Point& p) { return Key{p.x, p.y, p.z}; };
  std::map<std::pair<Key, Key>, std::vector<std::pair<int, int>>> edges;
  for (int i = 0; i < size(); ++i) {
    if (primitives_[i].kind != Kind::kTriangle) continue;
    for (int e = 0; e < 3; ++e) {
      const auto a = key(primitives_[i].at[e]), b = key(primitives_[i].at[(e + 1) % 3]);
      primitives_[i].edge_up[e] = a < b;
      edges[std::minmax(a, b)].emplace_back(i, e);
    }
  }
  for (const auto& [ends, sides] : edges) {
    if (sides.size() != 2) continue;
    for (int k = 0; k < 2; ++k)
      primitives_[sides[k].first].neighbour[sides[k].second] = sides[1 - k].first;
  }
}

ExactGeometry::OnSurface ExactGeometry::point(int i, Vec2 u) const {
  const Primitive& p = primitives_[i];
  const double turn = 2 * std::numbers::pi * u.y;
  const Frame frame = Frame::around(p.normal);
  const Point around = frame.s * std::cos(turn) + frame.t * std::sin(turn);
  switch (p.kind) {
    case Kind::kTriangle: {
      if (u.x + u.y > 1) u = {1 - u.x, 1 - u.y};
      return {p.at[0] + (p.at[1] - p.at[0]) * u.x + (p.at[2] - p.at[0]) * u.y, p.normal};
    }
    case Kind::kPatch: {
      const Point e = p.at[1] - p.at[0], f = p.at[2] - p.at[0],
                  g = (p.at[3] - p.at[2]) - (p.at[1] - p.at[0]);
      return {p.at[0] + e * u.x + f * u.y + g * (u.x * u.y),
              normalized(cross(e + g * u.y, f + g * u.x))};
    }
    case Kind::kSphere: {
      const double z = 2 * u.x - 1;
      const Point out = p.normal * z + around * std::sqrt(1 - z * z);
      return {p.at[0] + out * p.radius, out};
    }
    case Kind::kDisk:
      return {p.at[0] + around * (p.radius * u.x), p.normal};
    case Kind::kCylinder:
      return {p.at[0] + p.normal * (p.half_height * (2 * u.x - 1)) + around * p.radius, around};
  }
  return {};
}

void ExactGeometry::add(Primitive p, const Point& centre, double reach) {
  p.centre = centre, p.reach = reach, p.error = instance_error_;
  primitives_.push_back(p);
}

}  // namespace lucerna::testing
