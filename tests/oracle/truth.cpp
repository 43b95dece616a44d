#include "tests/oracle/truth.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace lucerna::oracle {
namespace {

constexpr Real kPi = std::numbers::pi_v<Real>;
/// One rounding to a float.
constexpr Real kRoundoff = 0x1p-24L;
/// Roundings that a coordinate may have: of the vertex, of the point, and those of a ray.
constexpr Real kRoundings = 4;
/// The most cells of an emitter; with more the answer is unsure.
constexpr int kMostCells = 20000;
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

/// The corners of flat shapes; for disks and spheres the corners of a box around them.
std::vector<Vec> hull(const Shape& shape) {
  const auto& [a, b, c] = shape.at;
  if (shape.kind == ShapeKind::kTriangle) return {a, b, c};
  if (shape.kind == ShapeKind::kParallelogram) return {a, b, c, b + (c - a)};
  Vec reach{shape.radius, shape.radius, shape.radius};
  if (shape.kind == ShapeKind::kDisk) {
    const Vec n = unit(b - a);
    reach = {std::sqrt(std::fmax(0, 1 - n.x * n.x)) * shape.radius,
             std::sqrt(std::fmax(0, 1 - n.y * n.y)) * shape.radius,
             std::sqrt(std::fmax(0, 1 - n.z * n.z)) * shape.radius};
  }
  return {a - reach, a + reach};
}

Vec normal_of(const Shape& shape) {
  const auto& [a, b, c] = shape.at;
  return shape.kind == ShapeKind::kDisk ? unit(b - a) : unit(cross(b - a, c - a));
}

/// The corners in order around the shape.
std::vector<Vec> outline(const Shape& shape) {
  const auto& [a, b, c] = shape.at;
  if (shape.kind == ShapeKind::kTriangle) return {a, b, c};
  return {a, b, b + (c - a), c};
}

/// The corners of a polygon around the flat shape, in order.
std::vector<Vec> surroundings(const Shape& shape) {
  if (shape.kind != ShapeKind::kDisk) return outline(shape);
  constexpr int kCorners = 64;
  const Vec n = normal_of(shape);
  const Vec other = std::fabs(n.x) < 0.6L ? Vec{1, 0, 0} : Vec{0, 1, 0};
  const Vec u = unit(cross(other, n)), v = cross(n, u);
  std::vector<Vec> corners;
  for (int i = 0; i < kCorners; ++i) {
    const Real angle = 2 * kPi * i / kCorners;
    corners.push_back(shape.at[0] + (u * std::cos(angle) + v * std::sin(angle)) *
                                        (shape.radius / std::cos(kPi / kCorners)));
  }
  return corners;
}

/// How far inside of the flat shape's border a point of its plane lies; negative outside, where it
/// is at most the distance.
Real inside_by(const Shape& shape, const Vec& n, const Vec& p) {
  if (shape.kind == ShapeKind::kDisk) return shape.radius - length(p - shape.at[0]);
  const std::vector<Vec> corners = outline(shape);
  Real least = std::numeric_limits<Real>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec edge = corners[(i + 1) % corners.size()] - corners[i];
    least = std::fmin(least, dot(cross(n, edge), p - corners[i]) / length(edge));
  }
  return least;
}

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

/// Whether the convex hull of `corners`, seen from `eye`, is surely apart from a convex shape.
/// `error`: how far off the shape and the points may be.
bool surely_apart(const Shape& shape, const Vec& eye, const std::array<Vec, 4>& corners,
                  Real error) {
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
  const auto all_beyond = [&](const Vec& from, const Vec& n) {
    return std::ranges::all_of(corners,
                               [&](const Vec& p) { return dot(p - from, n) > error * length(n); });
  };
  // On one side of its plane.
  Vec n = normal_of(shape);
  if (dot(eye - shape.at[0], n) < 0) n = -n;
  if (dot(eye - shape.at[0], n) > error && all_beyond(shape.at[0], n)) return true;
  // Outside of one of its edges, as the eye sees them.
  const std::vector<Vec> around = surroundings(shape);
  Vec middle{};
  for (const Vec& p : around) middle = middle + p * (1 / static_cast<Real>(around.size()));
  for (std::size_t i = 0; i < around.size(); ++i) {
    Vec m = cross(around[i] - eye, around[(i + 1) % around.size()] - eye);
    if (dot(middle - eye, m) > 0) m = -m;
    if (all_beyond(eye, m)) return true;
  }
  return false;
}

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
                             length(rounding(other)) + length(rounding(c.at->at)) +
                                 length(rounding(middle))))
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
  const Vec other = std::fabs(normal.x) < 0.6L ? Vec{1, 0, 0} : Vec{0, 1, 0};
  const Vec u = unit(cross(other, normal));
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
