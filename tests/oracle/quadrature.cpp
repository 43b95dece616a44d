#include "tests/oracle/quadrature.h"

#include <algorithm>
#include <limits>
#include <queue>
#include <span>

#include "tests/oracle/oracle_gauss.h"
#include "tests/oracle/oracle_shapes.h"

namespace lucerna::oracle {
namespace {

/// The most cells of an emitter.
constexpr int kMostCells = 500;
/// The relative bound at which the division stops.
constexpr Real kEnough = 0.003L;
/// A cell is divided if its middle is nearer than this many radii.  The error of a rule of n points
/// falls with the power 2 n of this number.
constexpr Real kFarther = 2.5L;

std::span<const Vec> points_of(const Cell::Hull& hull) {
  return {hull.points.data(), static_cast<std::size_t>(hull.count)};
}

/// The two halves across the longer side.
std::pair<Cell, Cell> halves(const Cell& c) {
  const Real sm = (c.s0 + c.s1) / 2, tm = (c.t0 + c.t1) / 2;
  const bool split_s = length(c.point(c.s1, tm) - c.point(c.s0, tm)) >=
                       length(c.point(sm, c.t1) - c.point(sm, c.t0));
  std::pair<Cell, Cell> two{c, c};
  if (split_s)
    two.first.s1 = two.second.s0 = sm;
  else
    two.first.t1 = two.second.t0 = tm;
  return two;
}

}  // namespace

Quadrature::Quadrature(const Truth& truth, const Integral& integral, const Emitter& emitter)
    : truth_(truth), integral_(integral), emitter_(emitter) {
  const Place& at = integral.at;
  const Vec here = truth.rounding(at.at);
  Vec off = here;
  if (emitter.shape >= 0)
    off = off + truth.rounding(truth.world().shapes[static_cast<std::size_t>(emitter.shape)]);
  const Real most = length(off);
  Vec up = emitter.surface != nullptr && is_flat(*emitter.surface) ? normal_of(*emitter.surface)
           : integral.is_solid_angle()                             ? unit(emitter.corner - at.at)
                                                                   : integral.normal;
  if (!(length(up) > 0)) up = {0, 0, 1};
  // A flat emitter moves across its plane by less than in it.
  const Vec u = across(up);
  moves_ = {up * dot(absolute(up), off), u * most, cross(up, u) * most};
  if (integral.is_solid_angle()) return;
  for (std::size_t i = 0; i < truth.world().shapes.size(); ++i) {
    const Shape& shape = truth.world().shapes[i];
    if (is_curved(shape)) {
      curved_.push_back(&shape);
      continue;
    }
    const bool own = at.on == static_cast<int>(i);
    if (emitter.shape == static_cast<int>(i) || (own && is_flat(shape))) continue;
    Occluder o{.shape = &shape, .own = own, .off = truth.rounding(shape) + here};
    if (is_flat(shape)) {
      o.normal = normal_of(shape);
      o.height = dot(at.at - shape.at[0], o.normal);
      if (o.height < 0) o.normal = -o.normal, o.height = -o.height;
      const std::vector<Vec> corners = surroundings(shape);
      Vec inside{};
      for (const Vec& p : corners) inside = inside + p * (1 / static_cast<Real>(corners.size()));
      for (std::size_t k = 0; k < corners.size(); ++k) {
        Vec m = cross(corners[k] - at.at, corners[(k + 1) % corners.size()] - at.at);
        if (!(length(m) > 0)) continue;
        m = unit(m);
        o.around.push_back(dot(inside - at.at, m) > 0 ? -m : m);
      }
    }
    occluders_.push_back(std::move(o));
  }
}

bool Quadrature::surely_apart(const Occluder& o, const Cell::Hull& hull) const {
  const auto points = points_of(hull);
  const Vec& eye = integral_.at.at;
  const Vec off = o.off + truth_.rounding(points[0]);
  if (o.shape->kind == ShapeKind::kSphere) {
    Vec middle{};
    for (const Vec& p : points) middle = middle + p * (1 / static_cast<Real>(points.size()));
    Real radius = 0;
    for (const Vec& p : points) radius = std::max<Real>(radius, length(p - middle));
    const Vec along = middle - eye;
    const Real distance = length(along);
    const Real t =
        std::clamp(dot(o.shape->at[0] - eye, along) / distance, Real{0}, distance) / distance;
    return length(eye + along * t - o.shape->at[0]) > o.shape->radius + length(off) + radius * t;
  }
  const auto all_beyond = [&](const Vec& from, const Vec& n, Real by) {
    return std::ranges::all_of(points, [&](const Vec& p) { return dot(p - from, n) > by; });
  };
  const Real across = dot(absolute(o.normal), off);
  if (o.height > across && all_beyond(o.shape->at[0], o.normal, across)) return true;
  const Real error = length(off);
  return std::ranges::any_of(o.around, [&](const Vec& n) { return all_beyond(eye, n, error); });
}

Way Quadrature::past(const Occluder& o, const Cell::Hull& hull) const {
  if (!o.own && surely_apart(o, hull)) return Way::kFree;
  const bool far = emitter_.far || emitter_.shape < 0;
  // All corners behind one convex shape: so is the cell.
  const auto all = [&](Way way) {
    return std::ranges::all_of(points_of(hull), [&](const Vec& p) {
      return truth_.past(*o.shape, integral_.at, {.at = p, .on = emitter_.shape, .far = far}) ==
             way;
    });
  };
  if (all(Way::kBlocked)) return Way::kBlocked;
  // A sphere hides nothing that is over its tangent plane.
  return o.own && all(Way::kFree) ? Way::kFree : Way::kUnsure;
}

Way Quadrature::past_curved_shape(const Shape& shape, const Cell& c, const Cell::Hull& hull) const {
  const bool self = emitter_.shape >= 0 &&
                    &shape == &truth_.world().shapes[static_cast<std::size_t>(emitter_.shape)];
  const bool far = emitter_.far || emitter_.shape < 0;
  Vec lower = hull.points[0], upper = lower;
  for (const Vec& p : points_of(hull)) {
    lower = {std::min<Real>(lower.x, p.x), std::min<Real>(lower.y, p.y),
             std::min<Real>(lower.z, p.z)};
    upper = {std::max<Real>(upper.x, p.x), std::max<Real>(upper.y, p.y),
             std::max<Real>(upper.z, p.z)};
  }
  const Vec middle = (lower + upper) * 0.5L;
  const Real angular = emitter_.reach * 0x1p-22L;
  const Vec error = self ? Vec{} : far ? Vec{angular, angular, angular} : truth_.rounding(middle);
  const End to{box_about(middle, (upper - lower) * 0.5L + error), self, {c.s0, c.s1}, {c.t0, c.t1}};
  return past_curved(shape, self ? Vec{} : truth_.rounding(shape),
                     truth_.end(integral_.at, shape, integral_.at), to);
}

Way Quadrature::way_to(const Cell& cell, const Cell::Hull& hull) const {
  if (integral_.is_solid_angle()) return Way::kFree;
  Real lowest = std::numeric_limits<Real>::infinity(), highest = -lowest;
  for (const Vec& p : points_of(hull)) {
    const Real height = dot(p - integral_.at.at, integral_.normal);
    lowest = std::min<Real>(lowest, height);
    highest = std::max<Real>(highest, height);
  }
  if (highest <= 0) return Way::kBlocked;  // below the horizon
  Way way = lowest >= 0 || emitter_.kind == Emitter::Kind::kSky ? Way::kFree : Way::kUnsure;
  const auto add = [&](Way one) {
    if (one != Way::kFree) way = one;
    return one == Way::kBlocked;
  };
  for (const Occluder& o : occluders_)
    if (add(past(o, hull))) return way;
  for (const Shape* shape : curved_)
    if (add(past_curved_shape(*shape, cell, hull))) return way;
  return way;
}

Real Quadrature::integrand(const Cell& cell, const Cell::Element& element, const Vec& off) const {
  const Vec d = element.at - integral_.at.at - off;
  const Real omega = cell.solid_angle(element, d);
  if (integral_.is_solid_angle()) return omega;
  return std::max(Real{0}, dot(d, integral_.normal)) / length(d) * omega;
}

std::optional<Quadrature::Part> Quadrature::part(const Cell& c) const {
  if (c.faces_away()) return std::nullopt;
  const Cell::Hull hull = c.hull();
  const Way way = way_to(c, hull);
  if (way == Way::kBlocked) return std::nullopt;
  const Vec middle = c.point((c.s0 + c.s1) / 2, (c.t0 + c.t1) / 2);
  Real radius = 0;
  if (emitter_.kind == Emitter::Kind::kFlat) {
    for (const Real s : {c.s0, c.s1})
      for (const Real t : {c.t0, c.t1})
        radius = std::max<Real>(radius, length(c.point(s, t) - middle));
  } else {
    for (const Vec& p : points_of(hull)) radius = std::max<Real>(radius, length(p - middle));
  }
  const Real distance = length(middle - integral_.at.at);
  const auto by = [&](const Nodes& nodes, const Vec& off) {
    return c.radiance *
           integral_over(nodes, [&](const auto& element) { return integrand(c, element, off); });
  };
  if (!(distance > kFarther * radius)) {
    const Real half = c.radiance * (integral_.is_solid_angle() ? 2 : 1) * kPi / 2;
    return Part{c, half, half};
  }
  if (way == Way::kUnsure) {
    // The largest cosine times the solid angle, with a margin for what two points in each direction
    // do not see.
    Real highest = 0;
    for (const Vec& p : points_of(hull))
      highest = std::max<Real>(highest, dot(p - integral_.at.at, integral_.normal));
    const bool far = emitter_.kind == Emitter::Kind::kFlat && emitter_.far;
    const Real cosine = std::min<Real>(
        1, far ? highest / emitter_.reach + radius / distance : highest / (distance - radius));
    const Real omega = integral_over(nodes_of(c, kTwo), [&](const auto& element) {
      return c.solid_angle(element, element.at - integral_.at.at);
    });
    // At most that of the sphere around the cell.
    const Real share = radius / distance;
    const Real sphere = 2 * kPi * (1 - std::sqrt((1 - share) * (1 + share)));
    const Real half = c.radiance * cosine * std::min<Real>(omega * (1 + 4 * share), sphere) / 2;
    return Part{c, half, half};
  }
  // The second term is the bound if the first one is small by chance.
  const Nodes three = nodes_of(c, kThree);
  const Real value = by(nodes_of(c, kFour), {}), coarse = by(three, {});
  const Real coarsest = by(nodes_of(c, kTwo), {});
  Real bound = 2 * std::fabs(value - coarse) + std::fabs(coarse - coarsest) / 64;
  for (const Vec& move : moves_) bound += 2 * std::fabs(by(three, move) - coarse);
  return Part{c, value, bound};
}

Amount Quadrature::run(Real radiance, const Texels& picture) const {
  const auto less = [](const Part& a, const Part& b) { return a.bound < b.bound; };
  std::priority_queue<Part, std::vector<Part>, decltype(less)> parts(less);
  Amount sum;
  const auto add = [&](const Cell& cell) {
    ++sum.cells;
    const auto p = part(cell);
    if (!p) return;
    sum.value += p->value;
    sum.bound += p->bound;
    parts.push(*p);
  };
  for (const Cell& cell : cells_of(emitter_, radiance, picture)) add(cell);
  while (!parts.empty() && sum.bound > kEnough * sum.value && sum.cells < kMostCells) {
    const Part worst = parts.top();
    parts.pop();
    sum.value -= worst.value;
    sum.bound -= worst.bound;
    const auto [one, two] = halves(worst.cell);
    add(one);
    add(two);
  }
  // Without what the differences have rounded.
  sum.value = sum.bound = 0;
  for (; !parts.empty(); parts.pop()) {
    sum.value += parts.top().value;
    sum.bound += parts.top().bound;
  }
  return sum;
}

}  // namespace lucerna::oracle
