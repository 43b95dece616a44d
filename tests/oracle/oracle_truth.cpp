#include "tests/oracle/oracle_truth.h"

#include <algorithm>
#include <limits>

#include "tests/oracle/oracle_shapes.h"

namespace lucerna::oracle {
namespace {

/// One rounding to a float.
constexpr Real kRoundoff = 0x1p-24L;
/// Roundings that a coordinate may have: of the vertex, of the point, and those of a ray.
constexpr Real kRoundings = 4;
/// The least difference that floats keep, in the server's unit.
constexpr Real kTiny = 0x1p-120L;
/// The error of the coordinates of a point of a request, relative to the largest one.
constexpr Real kOfPoint = 0x1p-21L;
/// A point lies on a surface that is within this many errors: twice its own and that of a ray.
constexpr Real kNear = 6.5L;
/// A way from a point without a normal begins within this many errors.
constexpr Real kLoose = 17;
/// The error of a direction: per metre of the way.
constexpr Real kOfDirection = kRoundings * kRoundoff;

struct Bounds {
  Vec lower{std::numeric_limits<Real>::infinity(), std::numeric_limits<Real>::infinity(),
            std::numeric_limits<Real>::infinity()};
  Vec upper = -lower;
  void add(const Vec& p) {
    lower = {std::fmin(lower.x, p.x), std::fmin(lower.y, p.y), std::fmin(lower.z, p.z)};
    upper = {std::fmax(upper.x, p.x), std::fmax(upper.y, p.y), std::fmax(upper.z, p.z)};
  }
};

bool has_place(const Light& light) {
  return light.kind != LightKind::kDistant && light.kind != LightKind::kSun &&
         light.kind != LightKind::kSky;
}

}  // namespace

Shape at_time(const Shape& shape, Real time) {
  Shape moved = shape;
  const bool has_axis = shape.kind == ShapeKind::kDisk || shape.kind == ShapeKind::kCylinder;
  for (std::size_t i = 0; i < (has_axis ? 1 : moved.at.size()); ++i)
    moved.at[i] = moved.at[i] + shape.moves * time;
  return moved;
}

World at_its_time(const World& world) {
  World moved = world;
  for (Shape& shape : moved.shapes) shape = at_time(shape, world.time);
  for (Light& light : moved.lights) light.at = light.at + light.moves * world.time;
  return moved;
}

Amount& Amount::operator+=(const Amount& other) {
  value += other.value;
  bound += other.bound;
  sure = sure && other.sure;
  cells += other.cells;
  return *this;
}

Truth::Truth(const World& world) : world_(at_its_time(world)) {
  Bounds box;
  for (const Shape& shape : world.shapes) {
    Bounds own;
    for (const Vec& p : hull(shape)) {
      own.add(p);
      box.add(p);
      box.add(p + shape.moves);
    }
    const Vec size = own.upper - own.lower;
    const Real extent = std::fmax(std::fmax(size.x, size.y), size.z);
    detail_ = detail_ > 0 ? std::fmin(detail_, extent) : extent;
  }
  if (world.shapes.empty()) {
    for (const Light& light : world.lights) {
      if (!has_place(light)) continue;
      box.add(light.at);
      box.add(light.at + light.moves);
    }
  }
  // The server keeps floats about the middle of the scene, rounded to a multiple of the smallest
  // power of two that is not below its extent.
  const Vec wide = box.upper - box.lower;
  const Real extent = std::fmax(std::fmax(wide.x, wide.y), wide.z);
  if (!(extent >= 0)) return;
  const Real step = extent > 0 ? std::exp2(std::ceil(std::log2(extent))) : 1;
  const auto middle = [&](Real lower, Real upper) {
    return std::nearbyint((lower + upper) / 2 / step) * step;
  };
  centre_ = {middle(box.lower.x, box.upper.x), middle(box.lower.y, box.upper.y),
             middle(box.lower.z, box.upper.z)};
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
  // A shape that moves is turned and shifted in floats.
  if (length(shape.moves) > 0) most = most * 2;
  return most;
}

// Rays meet a triangle with an error relative to the distance of its corners, unless it is level or
// so large that the error is a thousandth of the smallest shape.
Real Truth::start(const Shape& shape, const Vec& p) const {
  constexpr Real kOfCorners = 0x1p-20L, kMost = 1e-3L;
  const Vec n = absolute(normal_of(shape));
  if (std::fmax(std::fmax(n.x, n.y), n.z) == 1) return 0;
  Real farthest = 0;
  for (const Vec& corner : hull(shape)) farthest = std::fmax(farthest, length(corner - p));
  return std::fmin(kOfCorners * farthest, kMost * detail_);
}

Real Truth::near(const Place& place) const {
  const Vec d = absolute(place.at - centre_);
  if (!place.asked) return 0;
  Real near = kNear * kOfPoint * std::fmax(std::fmax(d.x, d.y), d.z);
  if (place.on >= 0) {
    const Shape& own = world_.shapes[static_cast<std::size_t>(place.on)];
    if (is_flat(own)) near += 4 * start(own, place.at);
  }
  return near;
}

Real Truth::blur(const Place& place) const {
  return dot(place.normal, place.normal) > 0 ? 0 : near(place) * (kLoose / kNear);
}

Real Truth::shift(const Place& place) const {
  if (place.asked && place.on >= 0) {
    const Shape& own = world_.shapes[static_cast<std::size_t>(place.on)];
    return is_flat(own) ? 4 * start(own, place.at) : 0;
  }
  if (!place.asked || !(length(place.normal) > 0)) return 0;
  const Vec d = absolute(place.at - centre_), n = absolute(unit(place.normal));
  return (n.x + n.y + n.z) * kOfPoint * std::fmax(std::fmax(d.x, d.y), d.z);
}

bool Truth::may_lie_on(const Shape& shape, const Place& place) const {
  Place probe = place;
  probe.normal = {};
  const Real reach = 2 * (length(rounding(shape)) + length(rounding(place.at)) + blur(probe));
  if (is_flat(shape)) {
    const Vec n = normal_of(shape);
    return std::fabs(dot(place.at - shape.at[0], n)) <= reach &&
           inside_by(shape, n, place.at) >= -reach;
  }
  if (shape.kind == ShapeKind::kSphere)
    return std::fabs(length(place.at - shape.at[0]) - shape.radius) <= reach;
  Bounds box;
  for (const Vec& p : hull(shape)) box.add(p);
  const auto apart = [&](Real at, Real lower, Real upper) {
    return std::fmax(0, std::fmax(lower - at, at - upper));
  };
  return std::fmax(std::fmax(apart(place.at.x, box.lower.x, box.upper.x),
                             apart(place.at.y, box.lower.y, box.upper.y)),
                   apart(place.at.z, box.lower.z, box.upper.z)) <= reach;
}

Real Truth::reach(const Vec& at) const {
  Real reach = 0;
  for (const Shape& shape : world_.shapes) {
    for (const Vec& p : hull(shape)) reach = std::fmax(reach, length(p - at));
  }
  // Without shapes, far enough to have a direction.
  return 2 * reach + 1e-6L * length(at) + 1e-30L;
}

Way Truth::past_flat(const Shape& shape, const Place& from, const Place& to) const {
  const int number = static_cast<int>(&shape - world_.shapes.data());
  const Vec n = normal_of(shape), along = to.at - from.at;
  const Real distance = length(along);
  const Vec of_shape = rounding(shape);
  const auto off_plane = [&](const Vec& p) { return dot(absolute(n), of_shape + rounding(p)); };
  const Real from_error = off_plane(from.at) + shift(from);
  const Real to_error = (to.far ? kOfDirection * distance : off_plane(to.at)) + shift(to);
  const bool on_from = from.on == number, on_to = to.on == number;
  const Real a = dot(from.at - shape.at[0], n), b = dot(to.at - shape.at[0], n);
  // A request's point that is nearer than the triangle's own error may lie on it.
  const auto near_this = [&](const Place& place) {
    return near(place) + (place.asked ? 4 * start(shape, place.at) : 0);
  };
  const bool near_from = on_from || std::fabs(a) <= from_error + near_this(from);
  const bool near_to = on_to || std::fabs(b) <= to_error + near_this(to);
  const Real of_end = to.far ? 0 : length(rounding(to.at));
  const auto in_plane_at = [&](Real t) {
    return length(of_shape) + length(rounding(from.at)) + of_end + shift(from) + shift(to) +
           kOfDirection * t;
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
    // A request's point may lie on the surface or beside it.
    const Real error = from_error + to_error + near_this(near_from ? from : to);
    const Real shift = distance * 2 * error / std::fabs(near_from ? b : a);
    return inside_by(shape, n, p) < -(in_plane + shift) ? Way::kFree : Way::kUnsure;
  }
  if ((a < 0) == (b < 0)) return Way::kFree;
  const Real t = distance * a / (a - b);
  const Vec meeting = from.at + along * (t / distance);
  const Real cosine = std::fabs(a - b) / distance;
  const Real margin =
      in_plane_at(t) + (from_error + (to.far ? 0 : to_error)) / cosine + kOfDirection * t / cosine;
  const Real inside = inside_by(shape, n, meeting);
  if (inside > margin) {
    const bool loose = t <= blur(from) || distance - t <= blur(to);
    return loose ? Way::kUnsure : Way::kBlocked;
  }
  return inside < -margin ? Way::kFree : Way::kUnsure;
}

Way Truth::past_sphere(const Shape& shape, const Place& from, const Place& to) const {
  const int number = static_cast<int>(&shape - world_.shapes.data());
  const Vec &centre = shape.at[0], along = to.at - from.at;
  const Real distance = length(along), r = shape.radius;
  const Real reach = std::fmin(distance, length(centre - from.at) + r);
  const Real error = length(rounding(shape)) + length(rounding(from.at)) +
                     (to.far ? 0 : length(rounding(to.at))) + shift(from) + shift(to) +
                     kOfDirection * reach;
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
    const Real loose = error + std::fmax(near(other), blur(other));
    if (off > loose) return Way::kBlocked;
    return off < -loose ? Way::kFree : Way::kUnsure;
  }
  if (std::fabs(a) <= error + std::fmax(near(from), blur(from)) ||
      std::fabs(b) <= error + std::fmax(near(to), blur(to)))
    return Way::kUnsure;
  if ((a < 0) != (b < 0)) return Way::kBlocked;
  if (a < 0) return Way::kFree;  // both inside
  const Real t = std::clamp(dot(centre - from.at, w), Real{0}, distance);
  const Real gap = length(from.at + w * t - centre) - r;
  if (gap > error) return Way::kFree;
  return gap < -error ? Way::kBlocked : Way::kUnsure;
}

End Truth::end(const Place& place, const Shape& shape, const Place& other) const {
  Vec error = rounding(place.at);
  if (place.far) {
    const Real r = kOfDirection * length(place.at - other.at);
    error = {r, r, r};
  }
  const bool on = place.on == static_cast<int>(&shape - world_.shapes.data());
  const Real near = on ? 0 : Truth::near(place);
  const Real distance = length(place.at - other.at);
  return {box_about(place.at, error + Vec{near, near, near}), on, place.s, place.t,
          distance > 0 ? blur(place) / distance : 0};
}

Way Truth::past(const Shape& shape, const Place& from, const Place& to) const {
  if (is_curved(shape)) {
    const Way way = past_curved(shape, rounding(shape), end(from, shape, to), end(to, shape, from));
    // A way that grazes its own surface may end at it earlier.
    constexpr Real kGrazing = 0.3L;
    const Vec w = unit(to.at - from.at);
    const int number = static_cast<int>(&shape - world_.shapes.data());
    const auto grazes = [&](const Place& p) {
      if (p.on != number) return false;
      const SurfacePoint own =
          shape.kind == ShapeKind::kPatch ? point_of(shape, p.s, p.t) : nearest_point(shape, p.at);
      return std::fabs(dot(own.normal, w)) < kGrazing;
    };
    return way == Way::kBlocked && (grazes(from) || grazes(to)) ? Way::kUnsure : way;
  }
  return is_flat(shape) ? past_flat(shape, from, to) : past_sphere(shape, from, to);
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
