#include "tests/oracle/truth.h"

#include <algorithm>
#include <limits>

#include "tests/oracle/shapes.h"

namespace lucerna::oracle {
namespace {

/// One rounding to a float.
constexpr Real kRoundoff = 0x1p-24L;
/// Roundings that a coordinate may have: of the vertex, of the point, and those of a ray.
constexpr Real kRoundings = 4;
/// The least difference that floats keep, in the server's unit.
constexpr Real kTiny = 0x1p-120L;

struct Box {
  Vec lower{std::numeric_limits<Real>::infinity(), std::numeric_limits<Real>::infinity(),
            std::numeric_limits<Real>::infinity()};
  Vec upper = -lower;
  void add(const Vec& p) {
    lower = {std::fmin(lower.x, p.x), std::fmin(lower.y, p.y), std::fmin(lower.z, p.z)};
    upper = {std::fmax(upper.x, p.x), std::fmax(upper.y, p.y), std::fmax(upper.z, p.z)};
  }
};

}  // namespace

Truth::Truth(const World& world) : world_(world) {
  Box box;
  for (const Shape& shape : world.shapes) {
    for (const Vec& p : hull(shape)) box.add(p);
  }
  for (const Light& light : world.lights) {
    if (light.kind == LightKind::kPoint) box.add(light.at);
  }
  centre_ = (box.lower + box.upper) * 0.5L;
}

Vec Truth::rounding(const Vec& point) const {
  const Vec d = absolute(point - centre_);
  return (d + Vec{kTiny, kTiny, kTiny}) * (kRoundings * kRoundoff);
}

Vec Truth::rounding(const Shape& shape) const {
  Vec most;
  for (const Vec& p : hull(shape)) {
    const Vec r = rounding(p);
    most = {std::fmax(most.x, r.x), std::fmax(most.y, r.y), std::fmax(most.z, r.z)};
  }
  return most;
}

Way Truth::past_flat(const Shape& shape, const Place& from, const Place& to) const {
  const int number = static_cast<int>(&shape - world_.shapes.data());
  const Vec n = normal_of(shape), along = to.at - from.at;
  const Real distance = length(along);
  const Vec of_shape = rounding(shape);
  const Real of_direction = kRoundings * kRoundoff;  // per metre of the way
  const auto off_plane = [&](const Vec& p) { return dot(absolute(n), of_shape + rounding(p)); };
  const Real from_error = off_plane(from.at);
  const Real to_error = to.far ? of_direction * distance : off_plane(to.at);
  const bool on_from = from.on == number, on_to = to.on == number;
  const Real a = dot(from.at - shape.at[0], n), b = dot(to.at - shape.at[0], n);
  const bool near_from = on_from || std::fabs(a) <= from_error;
  const bool near_to = on_to || std::fabs(b) <= to_error;
  const Real of_end = to.far ? 0 : length(rounding(to.at));
  const auto in_plane_at = [&](Real t) {
    return length(of_shape) + length(rounding(from.at)) + of_end + of_direction * t;
  };
  const Real in_plane = in_plane_at(distance);
  if (near_from && near_to) {
    // The whole way is near the plane.
    const Real reach = distance + in_plane;
    return inside_by(shape, n, from.at) < -reach ? Way::kFree : Way::kUnsure;
  }
  if (on_from || on_to) return Way::kFree;  // it leaves a flat surface for ever
  if (near_from || near_to) {
    const Vec& p = near_from ? from.at : to.at;
    const Real error = from_error + to_error;
    const Real shift = distance * 2 * error / std::fabs(near_from ? b : a);
    return inside_by(shape, n, p) < -(in_plane + shift) ? Way::kFree : Way::kUnsure;
  }
  if ((a < 0) == (b < 0)) return Way::kFree;
  const Real t = distance * a / (a - b);
  const Vec meeting = from.at + along * (t / distance);
  const Real cosine = std::fabs(a - b) / distance;
  const Real margin =
      in_plane_at(t) + (from_error + (to.far ? 0 : to_error)) / cosine + of_direction * t / cosine;
  const Real inside = inside_by(shape, n, meeting);
  if (inside > margin) return Way::kBlocked;
  return inside < -margin ? Way::kFree : Way::kUnsure;
}

Way Truth::past_sphere(const Shape& shape, const Place& from, const Place& to) const {
  const int number = static_cast<int>(&shape - world_.shapes.data());
  const Vec &centre = shape.at[0], along = to.at - from.at;
  const Real distance = length(along), r = shape.radius;
  const Real reach = std::fmin(distance, length(centre - from.at) + r);
  const Real error = length(rounding(shape)) + length(rounding(from.at)) +
                     (to.far ? 0 : length(rounding(to.at))) + kRoundings * kRoundoff * reach;
  const bool on_from = from.on == number, on_to = to.on == number;
  const Real a = length(from.at - centre) - r, b = length(to.at - centre) - r;
  const Vec w = along * (1 / distance);
  if (on_from || on_to) {
    // The way within the sphere from its own point to the other side.
    const Place &own = on_from ? from : to, &other = on_from ? to : from;
    const Vec out = unit(own.at - centre), away = on_from ? w : -w;
    const Real cosine = dot(out, away);
    const Real off = on_from && on_to ? 0 : length(other.at - centre) - r;
    // Near the tangent plane the way may or may not dip into the sphere.
    if (std::fabs(cosine) * r <= 4 * (error + std::sqrt(error * r))) return Way::kUnsure;
    if (cosine > 0) return on_from && on_to ? Way::kUnsure : Way::kFree;
    if (on_from && on_to) return Way::kFree;
    if (off > error) return Way::kBlocked;
    return off < -error ? Way::kFree : Way::kUnsure;
  }
  if (std::fabs(a) <= error || std::fabs(b) <= error) return Way::kUnsure;
  if ((a < 0) != (b < 0)) return Way::kBlocked;
  if (a < 0) return Way::kFree;  // both inside
  const Real t = std::clamp(dot(centre - from.at, w), Real{0}, distance);
  const Real gap = length(from.at + w * t - centre) - r;
  if (gap > error) return Way::kFree;
  return gap < -error ? Way::kBlocked : Way::kUnsure;
}

Way Truth::past(const Shape& shape, const Place& from, const Place& to) const {
  return shape.kind == ShapeKind::kSphere ? past_sphere(shape, from, to)
                                          : past_flat(shape, from, to);
}

Way Truth::way(const Place& from, const Place& to) const {
  Way result = Way::kFree;
  for (const Shape& shape : world_.shapes) {
    const Way one = past(shape, from, to);
    if (one == Way::kBlocked) return one;
    if (one == Way::kUnsure) result = one;
  }
  return result;
}

}  // namespace lucerna::oracle
