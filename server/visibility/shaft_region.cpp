#include "server/visibility/shaft_region.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/rays/error_bounds.h"

namespace lucerna {
namespace {

using Kind = LightOutline::Kind;

/// Surfaces so near before a flat light count as its plane, for each metre of coordinate or ray: a
/// ceiling in the plane of its lamp has the rounding of both.  Shadow rays end up to four times as
/// far before the light, so they pass obstacles there that the shaft has.
constexpr double kInPlane = 4 * kFloatRoundoff;
/// The largest distance of a shadow ray from its exact path, for each metre of coordinate and
/// ray.  Both ends are rounded, and the end is moved by 16 roundings along each axis.  Embree
/// finds surfaces to within as many roundings.
constexpr double kOff = 64 * kFloatRoundoff;

/// Adds sides through the apex and the edges of a polygon.  No corner may be at the apex.
void add_sides(std::span<const Vec3> corners, double slack, ShaftRegion& shaft) {
  Vec3 middle;
  shaft.lowest = 1;
  for (const Vec3& c : corners) {
    const Vec3 w = normalized(c - shaft.apex);
    middle += w;
    shaft.lowest = std::min({shaft.lowest, dot(w, shaft.up), dot(w, shaft.normal)});
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3 m =
        cross(normalized(a - shaft.apex), normalized(corners[(i + 1) % corners.size()] - a));
    const double sine = length(m);
    // An edge towards the receiver does not define a plane.  Without it, the shaft is wider.
    if (!(sine > 1e-6)) continue;
    const Vec3 n = m * ((dot(m, middle) > 0 ? -1 : 1) / sine);
    shaft.add(n, dot(n, shaft.apex) + slack, true);
  }
}

double largest_of(std::span<const Vec3> corners) {
  double largest = 0;
  for (const Vec3& c : corners) largest = std::fmax(largest, max_abs(c));
  return largest;
}

/// The box of apex and corners, wider by `slack`.
void add_box(std::span<const Vec3> corners, double slack, ShaftRegion& shaft) {
  Bounds box;
  box.add(shaft.apex);
  for (const Vec3& c : corners) box.add(c);
  const Vec3 around{slack, slack, slack};
  shaft.box.add(box.lower - around), shaft.box.add(box.upper + around);
}

/// The box of rays along any vector within `steps`, cut by `hittable`.
void add_infinite_box(const Bounds& steps, const Bounds& hittable, double slack,
                      ShaftRegion& shaft) {
  double last = Bounds::kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const auto leaves = [&](double at, double step) {
      last = std::fmin(last, std::fmax(0, (at - shaft.apex[axis]) / step));
    };
    if (steps.lower[axis] > 0) leaves(hittable.upper[axis] + 2 * slack, steps.lower[axis]);
    if (steps.upper[axis] < 0) leaves(hittable.lower[axis] - 2 * slack, steps.upper[axis]);
  }
  if (std::isinf(last)) return;
  const Vec3 around{slack, slack, slack};
  shaft.box.add(shaft.apex - around), shaft.box.add(shaft.apex + around);
  for (const Vec3& end : {steps.lower * last, steps.upper * last})
    shaft.box.add(shaft.apex + end - around), shaft.box.add(shaft.apex + end + around);
}

double slack_for(double largest_m) { return kOff * 2 * largest_m + 64 * double{kLeastError}; }

/// A lower bound on the components of all points of the corners' hull.
double least_coordinate(std::span<const Vec3> corners) {
  Bounds box;
  for (const Vec3& c : corners) box.add(c);
  double least = 0;
  for (int axis = 0; axis < 3; ++axis)
    least = std::fmax(least, std::fmax(box.lower[axis], -box.upper[axis]));
  return least;
}

bool add_flat(const LightOutline& light, ShaftRegion& shaft) {
  const double height = dot(light.axis, shaft.apex - light.corners[0]);
  shaft.largest_m = std::fmax(max_abs(shaft.apex), largest_of(light.corners));
  const double slack = slack_for(shaft.largest_m);
  if (!(std::fabs(height) > slack)) return false;
  add_sides(light.corners, slack, shaft);
  const Vec3 away = height > 0 ? -light.axis : light.axis;
  double nearest = Bounds::kInfinity;
  for (const Vec3& c : light.corners) nearest = std::fmin(nearest, dot(away, c));
  shaft.add(away,
            nearest - kInPlane * std::fmax(least_coordinate(light.corners), std::fabs(height)));
  add_box(light.corners, slack, shaft);
  return true;
}

bool add_sphere(const LightOutline& light, ShaftRegion& shaft) {
  const Vec3 to_center = light.center - shaft.apex;
  const double d = length(to_center), r = light.radius;
  shaft.largest_m = std::fmax(max_abs(shaft.apex), max_abs(light.center) + r);
  const double slack = slack_for(shaft.largest_m);
  if (!(d - r > slack)) return false;
  // The circle in which the cone from the receiver touches the sphere.  No ray ends behind it.
  const Vec3 axis = to_center / d;
  const double along = (d - r) / d * (d + r), radius = r * std::sqrt((d - r) / d * (d + r) / d);
  const auto frame = Frame::around(axis);
  const auto corners =
      polygon_around(shaft.apex + axis * along, frame.s * radius, frame.t * radius);
  add_sides(corners, slack, shaft);
  shaft.add(axis, dot(axis, shaft.apex) + along + slack);
  add_box(corners, slack, shaft);
  return true;
}

bool add_sun(const LightOutline& light, const Bounds& hittable, double slack, ShaftRegion& shaft) {
  // Wider suns may be anywhere above the horizon.
  constexpr double kWide = 1.3, kRounded = 1e-6;
  if (light.half_angle_rad > kWide) return true;
  const auto frame = Frame::around(light.axis);
  const double t = std::tan(light.half_angle_rad + kRounded);
  // As directions about zero, so that the apex's coordinates do not lose digits.
  const Vec3 apex = std::exchange(shaft.apex, {});
  const int first = shaft.count;
  const auto directions = polygon_around(light.axis, frame.s * t, frame.t * t);
  add_sides(directions, 0, shaft);
  shaft.apex = apex;
  Bounds steps;
  for (const Vec3& d : directions) steps.add(d);
  add_infinite_box(steps, hittable, slack, shaft);
  for (int i = first; i < shaft.count; ++i)
    shaft.planes[i].at = dot(shaft.planes[i].n, apex) + slack;
  return true;
}

}  // namespace

// Embree converts rays to the object's space in floats, which doubles their deviation.
ShaftRegion in_object(const ShaftRegion& shaft, const Transform& scene_from_object) {
  const auto& m = scene_from_object.matrix();
  const Transform inverse = scene_from_object.inverse();
  const auto row = [&](int i) {
    const auto& r = inverse.matrix()[i];
    return (std::fabs(r[0]) + std::fabs(r[1]) + std::fabs(r[2])) * shaft.largest_m +
           std::fabs(r[3]);
  };
  const Vec3 rounded = Vec3{row(0), row(1), row(2)} * (4 * kTraversalBound);
  ShaftRegion there = shaft;
  for (int i = 0; i < there.count; ++i) {
    HalfSpace& h = there.planes[i];
    const auto column = [&](int c) { return h.n.x * m[0][c] + h.n.y * m[1][c] + h.n.z * m[2][c]; };
    const Vec3 n{column(0), column(1), column(2)};
    h.at -= column(3);
    if (h.is_side)
      h.at += std::fabs(n.x) * rounded.x + std::fabs(n.y) * rounded.y + std::fabs(n.z) * rounded.z;
    h.n = n;
  }
  return there;
}

std::optional<ShaftRegion> shaft_region(const LightOutline& light, const SurfaceHit& receiver,
                                        const Vec3f& normal, const Bounds& hittable) {
  ShaftRegion shaft;
  shaft.normal = Vec3(normal);
  shaft.up = dot(receiver.ng, Vec3(normal)) < 0 ? -receiver.ng : receiver.ng;
  // The start of shadow rays, for either normal.
  shaft.apex =
      Vec3(offset_origin(Vec3f(receiver.position), receiver.position_error, receiver.ng, shaft.up));
  if (!is_finite(shaft.apex) || shaft.up == Vec3{}) return std::nullopt;
  const double reach_m =
      hittable.empty() ? 0 : std::fmax(max_abs(hittable.lower), max_abs(hittable.upper));
  shaft.largest_m = 2 * (max_abs(shaft.apex) + reach_m);  // for lights at infinity
  const double infinite_slack = slack_for(shaft.largest_m);
  bool is_known = true;
  switch (light.kind) {
    case Kind::kNone:
      return std::nullopt;
    case Kind::kFlat:
      is_known = add_flat(light, shaft);
      break;
    case Kind::kSphere:
      is_known = add_sphere(light, shaft);
      break;
    case Kind::kSun:
      is_known = add_sun(light, hittable, infinite_slack, shaft);
      break;
    case Kind::kPortal:
      is_known = dot(light.axis, light.corners[0] - shaft.apex) > infinite_slack;
      if (is_known) {
        add_sides(light.corners, infinite_slack, shaft);
        Bounds steps;
        for (const Vec3& c : light.corners) steps.add(c - shaft.apex);
        add_infinite_box(steps, hittable, infinite_slack, shaft);
      }
      break;
    case Kind::kSky:
      break;
  }
  if (!is_known) return std::nullopt;
  // Light that is below only one of the two horizons is not handled.
  if (Vec3f(shaft.up) != normal && !(shaft.lowest > kOff)) return std::nullopt;
  shaft.add(-shaft.up, -dot(shaft.up, shaft.apex));
  return shaft;
}

}  // namespace lucerna
