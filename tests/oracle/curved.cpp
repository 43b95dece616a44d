#include "tests/oracle/curved.h"

#include "tests/oracle/oracle_shapes.h"

namespace lucerna::oracle {
namespace {

/// Combines two places where the way may meet the surface.
Way either(Way a, Way b) {
  if (a == Way::kBlocked || b == Way::kBlocked) return Way::kBlocked;
  return a == Way::kUnsure ? a : b;
}

/// Whether numbers lie within intervals: a meeting exists if all do.
class Meeting {
 public:
  Meeting& needs(const Range& x, Real lo, Real hi, Real blur_lo = 0, Real blur_hi = 0) {
    if (x.apart(lo, hi)) free_ = true;
    if (!x.within(lo + blur_lo, hi - blur_hi)) sure_ = false;
    return *this;
  }
  bool is_free() const { return free_; }
  Way way() const { return free_ ? Way::kFree : sure_ ? Way::kBlocked : Way::kUnsure; }

 private:
  bool free_ = false, sure_ = true;
};

Range along(const Vec& axis, const Box& box, const Vec& from, Real off) {
  const Range x = (box.x - from.x) * axis.x + (box.y - from.y) * axis.y + (box.z - from.z) * axis.z;
  return {x.lo - off, x.hi + off};
}

/// The parts of the way, near its ends, where obstacles may count or not.
struct Blur {
  Real from, to;
};

/// In the cylinder's frame.
struct Local {
  Range x, y, z;
};

/// The way's meeting with the surface at parameter `tau` of it.
Way at_height(const Shape& shape, const Range& tau, const Local& f, const Local& d,
              const Blur& blur) {
  Meeting m;
  m.needs(tau, 0, 1, blur.from, blur.to);
  if (m.is_free()) return Way::kFree;
  const Range part{std::clamp(tau.lo, Real{0}, Real{1}), std::clamp(tau.hi, Real{0}, Real{1})};
  return m.needs(f.z + part * d.z, -shape.half_height, shape.half_height).way();
}

Way past_cylinder(const Shape& shape, const Vec& off, const End& from, const End& to) {
  if (to.on && !from.on) return past_cylinder(shape, off, to, from);
  const Vec &w = shape.at[1], u = across(w), v = cross(w, u);
  const auto local = [&](const Box& box) {
    return Local{along(u, box, shape.at[0], dot(absolute(u), off)),
                 along(v, box, shape.at[0], dot(absolute(v), off)),
                 along(w, box, shape.at[0], dot(absolute(w), off))};
  };
  const Local f = local(from.box), t = local(to.box);
  const Local d{t.x - f.x, t.y - f.y, t.z - f.z};
  const Real r = shape.radius;
  const Blur blur{from.blur, to.blur};
  const Range a = squared(d.x) + squared(d.y), b = f.x * d.x + f.y * d.y;
  if (from.on && to.on) {
    // The chord between them.  It is inside unless both lie nearly on one line of the surface.
    const Range x = (f.x + t.x) * Real{0.5L}, y = (f.y + t.y) * Real{0.5L};
    return (squared(x) + squared(y)).hi < r * r * 0.9999L ? Way::kFree : Way::kUnsure;
  }
  const Range apart = squared(f.x) + squared(f.y) - r * r,
              there = squared(t.x) + squared(t.y) - r * r;
  if (!(a.lo > 0)) {
    const Real reach = 2 * std::sqrt(a.hi) * r + a.hi;
    if (apart.lo > reach && there.lo > reach) return Way::kFree;
    return apart.hi < -reach && there.hi < -reach ? Way::kFree : Way::kUnsure;
  }
  if (from.on) {
    // The way's other meeting.  Rounding moves the start a little off the surface, which moves the
    // other end of a shallow chord far.
    const Real off_surface = std::max(std::fabs(apart.lo), std::fabs(apart.hi));
    const Range disc = squared(b) + a * Range{-off_surface, off_surface};
    const Range root = root_of(disc);
    if (disc.lo <= 0 || b.has(0)) {
      const Range both = (Range{-root.hi, root.hi} - b) / a;
      return at_height(shape, both, f, d, blur) == Way::kFree ? Way::kFree : Way::kUnsure;
    }
    return at_height(shape, ((b.lo > 0 ? -root : root) - b) / a, f, d, blur);
  }
  const Range moment = f.x * d.y - f.y * d.x;
  const Range disc = a * (r * r) - squared(moment);
  if (disc.hi < 0) return Way::kFree;
  const Range root = root_of(disc);
  if (disc.lo < 0) {
    const Range both = (Range{-root.hi, root.hi} - b) / a;
    return at_height(shape, both, f, d, blur) == Way::kFree ? Way::kFree : Way::kUnsure;
  }
  return either(at_height(shape, (-root - b) / a, f, d, blur),
                at_height(shape, (root - b) / a, f, d, blur));
}

/// The way's meeting with the line of the patch at parameter `u`.  `q`: the corners about the way's
/// start.
Way at_line(const std::array<Box, 4>& q, const Range& u, const Box& d, const Blur& blur) {
  Meeting m;
  if (m.needs(u, 0, 1).is_free()) return Way::kFree;
  const Range part{std::max(u.lo, Real{0}), std::min(u.hi, Real{1})};
  const Box p = q[0] + (q[1] - q[0]) * part, e = q[2] + (q[3] - q[2]) * part - p;
  const Box n = cross(e, d);
  const Range nn = squared(n.x) + squared(n.y) + squared(n.z);
  if (!(nn.lo > 0)) return Way::kUnsure;
  return m.needs(-(dot(cross(p, d), n) / nn), 0, 1)
      .needs(-(dot(cross(p, e), n) / nn), 0, 1, blur.from, blur.to)
      .way();
}

/// The same for an unknown parameter between two bounds.
Way at_lines(const std::array<Box, 4>& q, const Range& u, const Box& d, const Blur& blur) {
  return at_line(q, u, d, blur) == Way::kFree ? Way::kFree : Way::kUnsure;
}

/// Whether a plane surely separates the segment from all corners.  `q`: the corners as seen from
/// the start; `d`: the end.
bool misses_hull(const std::array<Box, 4>& q, const Box& d) {
  const auto middle = [](const Box& b) {
    return Vec{(b.x.lo + b.x.hi) / 2, (b.y.lo + b.y.hi) / 2, (b.z.lo + b.z.hi) / 2};
  };
  const Vec along = middle(d);
  const auto separates = [&](const Vec& normal) {
    const Box n{normal.x, normal.y, normal.z};
    const Range end = dot(d, n);
    const auto beyond = [&](bool above) {
      return std::ranges::all_of(q, [&](const Box& corner) {
        const Range h = dot(corner, n);
        return above ? h.lo > std::max(end.hi, Real{0}) : h.hi < std::min(end.lo, Real{0});
      });
    };
    return beyond(true) || beyond(false);
  };
  if (separates(along)) return true;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (separates(cross(along, middle(q[i]) - middle(q[k])))) return true;
  return false;
}

Way past_patch(const Shape& shape, const Vec& off, const End& from, const End& to) {
  if (to.on && !from.on) return past_patch(shape, off, to, from);
  const Blur blur{from.blur, to.blur};
  std::array<Box, 4> q;
  for (std::size_t i = 0; i < 4; ++i) q[i] = box_about(shape.at[i], off) - from.box;
  const Box d = to.box - from.box, e0 = q[1] - q[0], e1 = q[3] - q[2];
  if (!from.on && misses_hull(q, d)) return Way::kFree;
  const Range a = dot(d, cross(e0, e1));
  if (from.on) {
    const Box e = q[2] - q[0] + (e1 - e0) * from.s;
    const Range n = dot(d, cross(e0 * (Range{1} - from.t) + e1 * from.t, e));
    // A line meets the surface at most twice, and both ends are such meetings.
    if (to.on) return n.has(0) ? Way::kUnsure : Way::kFree;
    if (!a.has(0)) return at_line(q, from.s - n / a, d, blur);
    const Real least = std::min(std::fabs(n.lo), std::fabs(n.hi));
    if (!n.has(0) && least > std::max(std::fabs(a.lo), std::fabs(a.hi))) return Way::kFree;
    return Way::kUnsure;
  }
  const Range c = dot(d, cross(q[0], q[2]));
  const Range b = dot(d, cross(q[0], e1) + cross(e0, q[2]));
  const Range disc = squared(b) - a * c * Real{4};
  if (disc.hi < 0) return Way::kFree;
  const Range root = root_of(disc);
  if (disc.lo <= 0 || b.has(0)) {
    if (a.has(0)) return at_lines(q, {0, 1}, d, blur);
    if (disc.lo <= 0) return at_lines(q, (Range{-root.hi, root.hi} - b) / (a * Real{2}), d, blur);
    return either(at_line(q, (-root - b) / (a * Real{2}), d, blur),
                  at_line(q, (root - b) / (a * Real{2}), d, blur));
  }
  // Adds what has equal signs.
  const Range sum = (b.lo > 0 ? -(b + root) : root - b) * Real{0.5L};
  const Way one = sum.has(0) ? at_lines(q, {0, 1}, d, blur) : at_line(q, c / sum, d, blur);
  if (!a.has(0)) return either(one, at_line(q, sum / a, d, blur));
  const Real least = std::min(std::fabs(sum.lo), std::fabs(sum.hi));
  if (least > std::max(std::fabs(a.lo), std::fabs(a.hi))) return one;
  return either(one, at_lines(q, {0, 1}, d, blur));
}

}  // namespace

Way past_curved(const Shape& shape, const Vec& off, const End& from, const End& to) {
  return shape.kind == ShapeKind::kCylinder ? past_cylinder(shape, off, from, to)
                                            : past_patch(shape, off, from, to);
}

}  // namespace lucerna::oracle
