// Direct light by adaptive quadrature over emitters.
#include <algorithm>
#include <limits>

#include "tests/oracle/shapes.h"
#include "tests/oracle/truth.h"

namespace lucerna::oracle {
namespace {

/// The most cells of an emitter; with more the answer is unsure.
constexpr int kMostCells = 20000;

/// Whether the convex hull of `corners`, seen from `eye`, is surely apart from a convex shape.
/// `off`: how far off the shape and the points may be along each axis.
bool surely_apart(const Shape& shape, const Vec& eye, const std::array<Vec, 4>& corners,
                  const Vec& off) {
  const Real error = length(off);
  if (shape.kind == ShapeKind::kSphere) {
    Vec middle{};
    for (const Vec& p : corners) middle = middle + p * 0.25L;
    Real radius = 0;
    for (const Vec& p : corners) radius = std::fmax(radius, length(p - middle));
    const Vec along = middle - eye;
    const Real distance = length(along);
    const Real t = std::clamp(dot(shape.at[0] - eye, along) / distance, Real{0}, distance);
    return length(eye + along * (t / distance) - shape.at[0]) >
           shape.radius + error + radius * t / distance;
  }
  const auto all_beyond = [&](const Vec& from, const Vec& n, Real by) {
    return std::ranges::all_of(corners,
                               [&](const Vec& p) { return dot(p - from, n) > by * length(n); });
  };
  // On one side of its plane.
  Vec n = normal_of(shape);
  if (dot(eye - shape.at[0], n) < 0) n = -n;
  const Real across = dot(absolute(n), off);
  if (dot(eye - shape.at[0], n) > across && all_beyond(shape.at[0], n, across)) return true;
  // Outside of one of its edges, as the eye sees them.
  const std::vector<Vec> around = surroundings(shape);
  Vec middle{};
  for (const Vec& p : around) middle = middle + p * (1 / static_cast<Real>(around.size()));
  for (std::size_t i = 0; i < around.size(); ++i) {
    Vec m = cross(around[i] - eye, around[(i + 1) % around.size()] - eye);
    if (dot(middle - eye, m) > 0) m = -m;
    if (all_beyond(eye, m, error)) return true;
  }
  return false;
}

}  // namespace

Amount Truth::from_light(const Light& light, const Place& at) const {
  const bool distant = light.kind == LightKind::kDistant;
  Place end{light.at, {}, -1, distant};
  if (distant) {
    // Beyond all shapes.
    Real reach = 0;
    for (const Shape& shape : world_.shapes) {
      for (const Vec& p : hull(shape)) reach = std::fmax(reach, length(p - at.at));
    }
    end.at = at.at + light.at * (2 * reach + 1e-30L);
  }
  const Vec d = end.at - at.at;
  const Real distance = length(d), cosine = dot(unit(at.normal), d) / distance;
  const Real slant = (distant ? 0 : length(rounding(at.at)) / distance) + 0x1p-22L;
  if (std::fabs(cosine) <= 64 * slant) return {0, 0, false};
  if (cosine < 0) return {};
  const Way w = way(at, end);
  if (w == Way::kUnsure) return {0, 0, false};
  if (w == Way::kBlocked) return {};
  const Real value = light.level * cosine / (distant ? 1 : distance * distance);
  return {value, value * (4 * slant / cosine + 4 * slant), true};
}

struct Truth::Cell {
  int emitter;
  const Place* at;
  Vec n, normal;     ///< of the receiver and of the emitter, unit
  Vec corner, u, v;  ///< flat: corner + s u + t v; a disk: see `point`
  Real s0, s1, t0, t1;
  bool triangle, disk;

  Vec point(Real s, Real t) const {
    if (disk) {
      const Real angle = 2 * kPi * t;
      return corner + (u * std::cos(angle) + v * std::sin(angle)) * s;
    }
    return corner + u * s + v * (triangle ? t * (1 - s) : t);
  }
  /// Corners of a convex quadrangle that holds the cell.
  std::array<Vec, 4> hull() const {
    const Real wider = disk ? 1 / std::cos(kPi * (t1 - t0)) : 1;
    return {point(s0, t0), point(s1 * wider, t0), point(s0, t1), point(s1 * wider, t1)};
  }
  /// Area per s and t.
  Real stretch(Real s) const {
    const Real area = length(cross(u, v));
    if (disk) return 2 * kPi * s * area;
    return area * (triangle ? 1 - s : 1);
  }
  /// Illuminance per s and t, as if nothing were in the way.
  Real integrand(Real s, Real t, bool two_sided) const {
    const Vec d = point(s, t) - at->at;
    const Real squared = dot(d, d);
    if (!(squared > 0)) return 0;
    Real leaving = -dot(d, normal);
    if (two_sided) leaving = std::fabs(leaving);
    return std::fmax(0, dot(d, n)) * std::fmax(0, leaving) / (squared * squared) * stretch(s);
  }
};

void Truth::add_cell(const Cell& c, int depth, Amount& sum) const {
  if (++sum.cells > kMostCells) {
    sum.sure = false;
    return;
  }
  const Shape& emitter = world_.shapes[static_cast<std::size_t>(c.emitter)];
  const Real sm = (c.s0 + c.s1) / 2, tm = (c.t0 + c.t1) / 2;
  const Vec middle = c.point(sm, tm);
  const std::array<Vec, 4> corners = c.hull();
  Real radius = 0;
  for (const Vec& p : corners) radius = std::fmax(radius, length(p - middle));
  const Real distance = length(middle - c.at->at);
  Real lowest = std::numeric_limits<Real>::infinity(), highest = -lowest;
  for (const Vec& p : corners) {
    lowest = std::fmin(lowest, dot(p - c.at->at, c.n));
    highest = std::fmax(highest, dot(p - c.at->at, c.n));
  }
  if (highest <= 0) return;                                                 // below the horizon
  if (!emitter.two_sided && dot(middle - c.at->at, c.normal) >= 0) return;  // its back
  bool mixed = lowest < 0;
  for (std::size_t i = 0; i < world_.shapes.size() && !mixed; ++i) {
    const Shape& other = world_.shapes[i];
    const bool own = c.at->on == static_cast<int>(i);
    if (static_cast<int>(i) == c.emitter || (own && other.kind != ShapeKind::kSphere)) continue;
    if (!own && surely_apart(other, c.at->at, corners,
                             rounding(other) + rounding(c.at->at) + rounding(middle)))
      continue;
    // All corners behind one convex shape: so is the cell.
    const auto count = [&](Way way) {
      return std::ranges::count_if(corners, [&](const Vec& p) {
        return past(other, *c.at, {p, {}, c.emitter}) == way;
      });
    };
    if (count(Way::kBlocked) == 4) return;
    // A sphere hides nothing that is over its tangent plane.
    mixed = !own || count(Way::kFree) < 4;
  }
  constexpr int kDeepest = 40;
  const auto gauss = [&](Real s0, Real s1, Real t0, Real t1) {
    // Four points in each direction.
    constexpr std::array<Real, 4> kAt{
        0.0694318442029737123880267555536L, 0.330009478207571867598667120448L,
        0.669990521792428132401332879552L, 0.930568155797026287611973244446L};
    constexpr std::array<Real, 4> kWeight{
        0.173927422568726928686531974611L, 0.326072577431273071313468025389L,
        0.326072577431273071313468025389L, 0.173927422568726928686531974611L};
    Real total = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        total += kWeight[i] * kWeight[j] *
                 c.integrand(s0 + (s1 - s0) * kAt[i], t0 + (t1 - t0) * kAt[j], emitter.two_sided);
      }
    }
    return total * (s1 - s0) * (t1 - t0);
  };
  if (!mixed) {
    const Real whole = gauss(c.s0, c.s1, c.t0, c.t1);
    const Real parts = gauss(c.s0, sm, c.t0, tm) + gauss(sm, c.s1, c.t0, tm) +
                       gauss(c.s0, sm, tm, c.t1) + gauss(sm, c.s1, tm, c.t1);
    const Real error = std::fabs(whole - parts) * emitter.radiance;
    if ((error <= 1e-9L * sum.bound + 1e-8L * parts * emitter.radiance && distance > radius) ||
        depth >= kDeepest) {
      sum.value += parts * emitter.radiance;
      sum.bound += error;
      return;
    }
  } else {
    // At most the cell's illuminance from the nearest point of it.
    const Real nearest = std::fmax(distance - radius, 0);
    const Real area = kPi * radius * radius;
    const Real most = nearest > 0 ? emitter.radiance * std::fmin(kPi, area / (nearest * nearest))
                                  : emitter.radiance * kPi;
    if (depth >= 18 || most <= 1e-7L * sum.value) {
      sum.value += most / 2;
      sum.bound += most / 2;
      return;
    }
  }
  // Halves the longer side.
  const bool split_s = length(c.point(c.s1, tm) - c.point(c.s0, tm)) >=
                       length(c.point(sm, c.t1) - c.point(sm, c.t0));
  Cell one = c, two = c;
  if (split_s)
    one.s1 = two.s0 = sm;
  else
    one.t1 = two.t0 = tm;
  add_cell(one, depth + 1, sum);
  add_cell(two, depth + 1, sum);
}

Amount Truth::from_sphere(int emitter, const Place& at) const {
  const Shape& shape = world_.shapes[static_cast<std::size_t>(emitter)];
  const Vec d = shape.at[0] - at.at;
  const Real distance = length(d), r = shape.radius;
  const Real error = length(rounding(shape)) + length(rounding(at.at));
  if (distance <= r + 1e3L * error) return {0, 0, false};
  // Nothing may reach into the sphere: the disk below would be in front of it.
  for (std::size_t i = 0; i < world_.shapes.size(); ++i) {
    if (static_cast<int>(i) == emitter) continue;
    const Shape& other = world_.shapes[i];
    if (other.kind == ShapeKind::kSphere) {
      const Real apart = length(other.at[0] - shape.at[0]);
      if (apart < r + other.radius + error && other.radius < apart + r + error)
        return {0, 0, false};
      continue;
    }
    const Vec n = normal_of(other);
    const Real off = dot(shape.at[0] - other.at[0], n);
    if (std::fabs(off) < r + dot(absolute(n), rounding(other)) + error &&
        inside_by(other, n, shape.at[0] - n * off) > -r - error - length(rounding(other)))
      return {0, 0, false};
  }
  // It looks like the disk within the circle where the tangents from the receiver touch it.
  const Vec w = d * (1 / distance);
  const Real share = r / distance;
  const Real radius = r * std::sqrt((1 - share) * (1 + share));
  return from_disk(emitter, at, shape.at[0] - w * (r * share), -w, radius);
}

Amount Truth::from_disk(int emitter, const Place& at, const Vec& centre, const Vec& normal,
                        Real radius) const {
  const Vec u = across(normal);
  constexpr int kSectors = 8;
  Amount sum;
  for (int i = 0; i < kSectors; ++i) {
    add_cell({.emitter = emitter,
              .at = &at,
              .n = unit(at.normal),
              .normal = normal,
              .corner = centre,
              .u = u * radius,
              .v = cross(normal, u) * radius,
              .s0 = 0,
              .s1 = 1,
              .t0 = static_cast<Real>(i) / kSectors,
              .t1 = static_cast<Real>(i + 1) / kSectors,
              .triangle = false,
              .disk = true},
             0, sum);
  }
  return sum;
}

Amount Truth::once(int emitter, const Place& at) const {
  const Shape& shape = world_.shapes[static_cast<std::size_t>(emitter)];
  if (shape.kind == ShapeKind::kSphere) return from_sphere(emitter, at);
  const Vec normal = normal_of(shape);
  const Real plane = dot(absolute(normal), rounding(shape) + rounding(at.at));
  if (std::fabs(dot(at.at - shape.at[0], normal)) <= 4 * plane) return {0, 0, false};
  if (shape.kind == ShapeKind::kDisk)
    return from_disk(emitter, at, shape.at[0], normal, shape.radius);
  Amount sum;
  add_cell({.emitter = emitter,
            .at = &at,
            .n = unit(at.normal),
            .normal = normal,
            .corner = shape.at[0],
            .u = shape.at[1] - shape.at[0],
            .v = shape.at[2] - shape.at[0],
            .s0 = 0,
            .s1 = 1,
            .t0 = 0,
            .t1 = 1,
            .triangle = shape.kind == ShapeKind::kTriangle,
            .disk = false},
           0, sum);
  return sum;
}

Amount Truth::from_shape(int emitter, const Place& at) const {
  if (at.on == emitter) return {};
  Amount sum = once(emitter, at);
  if (!sum.sure || sum.value == 0) return sum;
  // What rounded places change.
  const Shape& shape = world_.shapes[static_cast<std::size_t>(emitter)];
  const Vec towards = unit(shape.at[0] - at.at);
  const Vec across = shape.kind == ShapeKind::kSphere ? unit(at.normal) : normal_of(shape);
  const Real error = length(rounding(shape)) + length(rounding(at.at));
  for (const Vec& way : {towards, across}) {
    const Real off = shape.kind == ShapeKind::kSphere
                         ? error
                         : dot(absolute(way), rounding(shape) + rounding(at.at));
    Place moved = at;
    moved.at = at.at + way * off;
    const Amount there = once(emitter, moved);
    sum.sure = sum.sure && there.sure;
    sum.bound += 4 * std::fabs(there.value - sum.value);
  }
  sum.bound += 1e-6L * sum.value;
  return sum;
}

Amount Truth::illuminance(const Place& at) const {
  Amount sum;
  const auto add = [&](const Amount& one) {
    sum.value += one.value;
    sum.bound += one.bound;
    sum.sure = sum.sure && one.sure;
  };
  for (const Light& light : world_.lights) add(from_light(light, at));
  for (std::size_t i = 0; i < world_.shapes.size(); ++i) {
    if (world_.shapes[i].radiance > 0) add(from_shape(static_cast<int>(i), at));
  }
  return sum;
}

}  // namespace lucerna::oracle
