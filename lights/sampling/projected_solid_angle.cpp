#include "lights/sampling/projected_solid_angle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lights/maths/gauss.h"

namespace lucerna {
namespace {

/// Sums smaller than this, relative to their terms, have lost three digits and are not used.
constexpr double kLeastShare = 1e-3;

/// The integral of `f` from `a` to `b` by Gauss's rule.  Halves an interval if its halves differ
/// from the whole.
template <typename F>
double integral(const F& f, double a, double b) {
  struct Sum {
    double value = 0, terms = 0;
  };
  const auto by_rule = [&f](double from, double to) {
    const Gauss<12>& rule = gauss<12>();
    Sum sum;
    for (std::size_t i = 0; i < 12; ++i) {
      const double term = rule.weight[i] * f(from + rule.node[i] * (to - from)) * (to - from);
      sum.value += term, sum.terms += std::fabs(term);
    }
    return sum;
  };
  const Sum all = by_rule(a, b);
  constexpr double kEnough = 1e-14;
  // A peak takes two halvings for each binary digit of its width.  More are useless: the rest is
  // the rounding of `f`.
  int halvings = 128;
  const auto halved = [&](const auto& self, double from, double to, const Sum& whole,
                          int left) -> double {
    const double middle = (from + to) / 2;
    const Sum first = by_rule(from, middle), second = by_rule(middle, to);
    const double sum = first.value + second.value;
    const double scale = std::fmax(all.terms, first.terms + second.terms);
    if (left == 0 || --halvings < 0 || !(std::fabs(sum - whole.value) > kEnough * scale))
      return sum;
    return self(self, from, middle, first, left - 1) + self(self, middle, to, second, left - 1);
  };
  constexpr int kDepth = 40;
  return halved(halved, a, b, all, kDepth);
}

/// A corner seen by the receiver, its height above the horizon, and the edge from it to the next
/// corner. The edge is stored too, because differences of corners lose digits for a small distant
/// polygon.
struct Corner {
  Vec3 v;
  double up;
  Vec3 edge;
};

/// A convex polygon of up to four corners, and its part above the horizon.  Rounding may cut a
/// polygon along the horizon at each edge.  Then each of the two corners above it becomes three.
struct Polygon {
  std::array<Corner, 6> corner;
  int count = 0;

  void add(const Corner& c) { corner[count++] = c; }
  const Vec3& next(int i) const { return corner[(i + 1) % count].v; }
};

/// The part above the horizon.  [Sutherland74]
Polygon above_horizon(const Polygon& whole) {
  Polygon kept;
  int cut = -1;
  for (int i = 0; i < whole.count; ++i) {
    const Corner& a = whole.corner[i];
    const Corner& b = whole.corner[(i + 1) % whole.count];
    const bool a_is_up = a.up > 0, b_is_up = b.up > 0;
    if (a_is_up && b_is_up) kept.add(a);
    if (a_is_up == b_is_up) continue;
    // Computed from the corner above the horizon, so that small parts stay exact.
    if (a_is_up) {
      const Vec3 down = a.edge * (a.up / (a.up - b.up));
      kept.add({a.v, a.up, down});
      cut = kept.count;
      kept.add({a.v + down, 0, {}});
    } else {
      const Vec3 risen = a.edge * (b.up / (b.up - a.up));
      kept.add({b.v - risen, 0, risen});
    }
  }
  // The edge along the horizon closes the others.
  if (cut >= 0)
    for (int i = 0; i < kept.count; ++i)
      if (i != cut) kept.corner[cut].edge += -kept.corner[i].edge;
  return kept;
}

/// The value of Lambert's sum over the edges, and the size of its terms.
struct EdgeSum {
  double value = 0, terms = 0;
};

/// Each edge counts with the angle that it subtends, times the cosine between the normal of its
/// plane and that of the receiver.
EdgeSum edge_sum(const Polygon& polygon, const Vec3& normal) {
  EdgeSum sum;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 &a = polygon.corner[i].v, &b = polygon.next(i);
    const Vec3& edge = polygon.corner[i].edge;
    const double aa = dot(a, a), bb = dot(b, b);
    const Vec3 m = cross(aa < bb ? a : b, edge);
    const double sine = length(m);
    if (!(sine > 0)) continue;
    // atan2: the arccosine of a.b loses half of its digits for small angles.
    const double angle = std::atan2(sine, dot(a, b));
    sum.value += angle * (dot(m, normal) / sine);
    sum.terms += angle + std::sqrt(dot(edge, edge) / std::fmax(aa, bb));
  }
  sum.value = std::fabs(sum.value) / 2;
  return sum;
}

struct Part {
  std::array<Vec3, 3> v;
  std::array<double, 3> up;
};

/// The integral of up / |v|^4 over a triangle that looks small from the receiver.
double by_rule(const Part& t) {
  const Gauss<8>& rule = gauss<8>();
  double sum = 0;
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < 8; ++j) {
      const double b1 = rule.node[i] * (1 - rule.node[j]), b2 = rule.node[i] * rule.node[j];
      const double b0 = 1 - rule.node[i];
      const Vec3 v = t.v[0] * b0 + t.v[1] * b1 + t.v[2] * b2;
      const double vv = dot(v, v);
      sum += rule.weight[i] * rule.weight[j] * rule.node[i] *
             ((t.up[0] * b0 + t.up[1] * b1 + t.up[2] * b2) / vv / vv);
    }
  return sum;
}

/// The same for any triangle, in units of twice its area.  It is halved across its longest side
/// until its parts are small.  Four equal parts would leave slivers as slivers, and need very many
/// parts near the receiver.  [Rivara84]
/// `parts`: how many more halvings are allowed.  A receiver next to a side takes a few for each
/// binary digit of its distance.
double by_parts(const Part& t, int depth, int& parts) {
  const Vec3 centre = (t.v[0] + t.v[1] + t.v[2]) / 3;
  const auto away = [&](int i) { return dot(t.v[i] - centre, t.v[i] - centre); };
  // At a distance of four times the radius, the rule of 8 by 8 nodes has an error of 1e-14.
  const double widest = 16 * std::max({away(0), away(1), away(2)});
  if (depth == 0 || !(widest > dot(centre, centre)) || --parts < 0) return by_rule(t);
  const auto side2 = [&](int i) {
    const Vec3 side = t.v[(i + 1) % 3] - t.v[i];
    return dot(side, side);
  };
  const std::array<double, 3> sides = {side2(0), side2(1), side2(2)};
  const int from = static_cast<int>(std::ranges::max_element(sides) - sides.begin());
  const int to = (from + 1) % 3;
  Part first = t, second = t;
  first.v[to] = second.v[from] = (t.v[from] + t.v[to]) * 0.5;
  first.up[to] = second.up[from] = (t.up[from] + t.up[to]) * 0.5;
  return (by_parts(first, depth - 1, parts) + by_parts(second, depth - 1, parts)) / 2;
}

/// height times the integral of up / |v|^4 over the polygon.  No term is negative.
double by_area(const Polygon& polygon, double height) {
  constexpr int kDepth = 120, kMostParts = 32768;
  const Corner& first = polygon.corner[0];
  double sum = 0;
  Vec3 to_b = first.edge;
  for (int i = 1; i + 1 < polygon.count; ++i) {
    const Corner &b = polygon.corner[i], &c = polygon.corner[i + 1];
    int parts = kMostParts;
    sum += length(cross(to_b, b.edge)) *
           by_parts({{first.v, b.v, c.v}, {first.up, b.up, c.up}}, kDepth, parts);
    to_b += b.edge;
  }
  return height * sum;
}

/// The part of a disk above a horizon that cuts it.  Its edge is the arc of the rim with |t| < T,
/// and the chord between the arc's ends.  The rim is center + x cos t + y sin t, with y along the
/// horizon.
class CutDisk {
 public:
  CutDisk(const Vec3& center, const Vec3& x, const Vec3& y, const Vec3& normal)
      : center_(center), x_(x), y_(y), normal_(normal), slope_(dot(x, normal)) {
    const double center_up = dot(center, normal);
    end_ = 2 * std::asin(std::sqrt(std::clamp((slope_ + center_up) / (2 * slope_), 0.0, 1.0)));
  }

  /// Half the integral of n.(p x dp) / |p|^2 along its edge, the arc and the chord.
  EdgeSum edges() const {
    const Vec3 across = cross(x_, y_), cx = cross(center_, x_), cy = cross(center_, y_);
    double terms = 0;
    const auto moved = [&](double t) {
      const double c = std::cos(t), s = std::sin(t);
      const Vec3 p = rim(c, s);
      return dot(across + cy * c - cx * s, normal_) / dot(p, p);
    };
    const double arc = integral(moved, -end_, 0) + integral(moved, 0, end_);
    const Vec3 from = rim(std::cos(end_), std::sin(end_));
    const Vec3 to = rim(std::cos(end_), -std::sin(end_));
    const double chord = std::atan2(dot(cross(from, to), normal_), dot(from, to));
    terms = std::fabs(arc) + std::fabs(chord);
    return {std::fabs(arc + chord) / 2, terms};
  }

  /// height times the integral of up / |v|^4 over the part, in rays from the middle of the chord.
  double by_area(double height) const {
    const Vec3 middle = center_ + x_ * std::cos(end_);
    const auto along = [&](double t) {
      const double before = std::sin((end_ - t) / 2), behind = std::sin((end_ + t) / 2);
      // Twice the area that is swept; the height above the horizon.
      const double swept = before * before + behind * behind, up = 2 * before * behind * slope_;
      const Vec3 out = x_ * (2 * before * behind) + y_ * std::sin(t);
      const auto outwards = [&](double s) {
        const Vec3 p = middle + out * s;
        const double pp = dot(p, p);
        return s * s / pp / pp;
      };
      return swept * up * integral(outwards, 0, 1);
    };
    return height * dot(x_, x_) * (integral(along, -end_, 0) + integral(along, 0, end_));
  }

 private:
  Vec3 rim(double cos, double sin) const { return center_ + x_ * cos + y_ * sin; }

  Vec3 center_, x_, y_, normal_;
  double slope_, end_;
};

/// The vector whose product with a normal is a disk's projected solid angle.  It is valid if the
/// disk is above the normal's horizon.  One component runs along the axis, away from the receiver.
/// The other runs along the plane, towards the centre.
struct DiskVector {
  double along_axis, along_plane;
};

/// For a receiver `offset` beside the axis and `height` above the plane.  With S = offset^2 +
/// radius^2 + height^2 and Q = sqrt(S^2 - (2 offset radius)^2), the components are pi/2 (1 - (S - 2
/// radius^2) / Q) and pi/2 height / offset (S / Q - 1).  The code avoids their differences.
DiskVector disk_vector(double offset, double height, double radius) {
  const double h2 = height * height, r2 = radius * radius, o2 = offset * offset;
  const double s = o2 + r2 + h2;
  const double q = std::sqrt((offset - radius) * (offset - radius) + h2) *
                   std::sqrt((offset + radius) * (offset + radius) + h2);
  const double beyond = (offset - radius) * (offset + radius) - h2;
  // S + Q - 2 offset^2
  const double facing = beyond > 0 ? 4 * o2 * h2 / (q + beyond) : q - beyond;
  return {kPi * r2 * facing / (q * (s + q)), 2 * kPi * height * offset * r2 / (q * (s + q))};
}

/// The part above the horizon of a cap whose axis is on the horizon or below it.
double peeking_cap(double sin_half, double cos_half, double sin_axis, double depth) {
  // The cap's edge is z = sin_half sin_axis (cos t - cos T) above the horizon.  Projected onto the
  // receiver's plane, the visible part lies between this edge and the unit circle.  Both ends of a
  // stretch at y satisfy x^2 + y^2 + z^2 = 1, with z = 0 on the circle.  So the length of the
  // stretch is z^2 over the sum of both x.
  const double highest = sin_half * sin_axis - cos_half * depth;
  if (!(highest > 0)) return 0;
  const double end = 2 * std::asin(std::sqrt(std::fmin(highest / (2 * sin_half * sin_axis), 1)));
  const auto stretch = [&](double t) {
    const double c = std::cos(t), s = std::sin(t);
    const double z = 2 * sin_half * sin_axis * std::sin((end + t) / 2) * std::sin((end - t) / 2);
    const double to_edge = cos_half * sin_axis + sin_half * depth * c;
    const double y = sin_half * s;
    return z * z * sin_half * c / (std::sqrt((1 - y) * (1 + y)) + to_edge);
  };
  return 2 * integral(stretch, 0, end);
}

}  // namespace

double polygon_projected_solid_angle(std::span<const Vec3> corners, const Vec3& receiver,
                                     const Vec3& normal, double height) {
  if (!(height != 0)) return 0;
  double farthest = 0;
  for (const Vec3& c : corners) farthest = std::fmax(farthest, max_abs(c - receiver));
  if (!(farthest > 0) || !std::isfinite(farthest)) return 0;
  // Scales lengths by a power of two to about 1, so that no square overflows or underflows.
  const int exponent = -std::ilogb(farthest);
  Polygon whole;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& next = corners[(i + 1) % corners.size()];
    const Vec3 v = scaled(corners[i] - receiver, exponent);
    whole.add({v, dot(v, normal), scaled(next - corners[i], exponent)});
  }
  const Polygon seen = above_horizon(whole);
  if (seen.count < 3) return 0;
  const EdgeSum sum = edge_sum(seen, normal);
  if (sum.value >= kLeastShare * sum.terms) return std::fmin(sum.value, kPi);
  return by_area(seen, std::scalbn(std::fabs(height), exponent));
}

double disk_projected_solid_angle(const Vec3& to_center, const Vec3& axis, double radius,
                                  double height, const Vec3& normal) {
  if (!(height != 0)) return 0;
  const double farthest = std::fmax(max_abs(to_center), radius);
  if (!(farthest > 0) || !std::isfinite(farthest)) return 0;
  const int exponent = -std::ilogb(farthest);
  const double r = std::scalbn(radius, exponent), h = std::scalbn(std::fabs(height), exponent);
  const Vec3 down = dot(to_center, axis) < 0 ? -axis : axis;
  const Vec3 c = scaled(to_center, exponent);
  const Vec3 beside = c - down * dot(c, down);
  const Vec3 center = down * h + beside;

  const Vec3 rising = normal - down * dot(normal, down);  // within the plane
  const double slope = r * length(rising), center_up = dot(center, normal);
  if (center_up + slope <= 0) return 0;
  if (center_up >= slope) {
    const DiskVector v = disk_vector(length(beside), h, r);
    return std::clamp(
        dot(normal, down) * v.along_axis + dot(normal, normalized(beside)) * v.along_plane, 0.0,
        kPi);
  }
  const Vec3 x = normalized(rising);
  const CutDisk cut(center, x * r, cross(down, x) * r, normal);
  const EdgeSum sum = cut.edges();
  if (sum.value >= kLeastShare * sum.terms) return std::fmin(sum.value, kPi);
  return cut.by_area(h);
}

double cap_projected_solid_angle(const Vec3& axis, double sin_half, double cos_half,
                                 const Vec3& normal) {
  const double cos_axis = dot(axis, normal), sin_axis = length(cross(axis, normal));
  const double all_above = kPi * sin_half * sin_half * cos_axis;
  if (cos_half * cos_axis >= sin_half * sin_axis) return std::fmax(all_above, 0);
  // The part above equals the signed whole plus the size of the part below.
  return std::fmax(all_above, 0) + peeking_cap(sin_half, cos_half, sin_axis, std::fabs(cos_axis));
}

}  // namespace lucerna
