#include "lights/shapes/triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lights/maths/triple_product.h"
#include "lights/sampling/low_triangle.h"
#include "lights/sampling/sampling.h"
#include "lights/sampling/spherical_triangle.h"

namespace lucerna {

namespace {

Vec3 area_vector(const Triangle& t) {
  const Vec3 a(t.a);
  return cross(t.b - a, t.c - a);
}

Vec3 at(const Triangle& t, const Vec3& barycentric) {
  // Computed from one vertex, so a triangle far from the origin keeps all digits of its vertices.
  const Vec3 a(t.a);
  return a + (t.b - a) * barycentric.y + (t.c - a) * barycentric.z;
}

/// A triangle seen by a receiver, and how its points are chosen.
struct Seen {
  Vec3 corner[3];  // from the receiver
  Vec3 normal;     // the receiver's
  double height;   // of the receiver
  AreaSampling way;
  std::optional<LowTriangle> low;  // comes first
  std::optional<SphericalTriangle> spherical;

  Seen(const Triangle& t, const Receiver& receiver)
      : corner{t.a - receiver.position, t.b - receiver.position, t.c - receiver.position},
        normal(receiver.normal),
        height(t.height_of(receiver.position)),
        way(way_for_corners(receiver.area_sampling, corner, normal, receiver.incomplete)) {
    if (is_by_area(way) || height == 0) return;
    low = LowTriangle::create(corner, normalized(area_vector(t)), height);
    if (!low) spherical = SphericalTriangle::create(t.a, t.b, t.c, receiver.position);
  }

  /// Weights of the corners in the unit square of SphericalTriangle, where b is a whole side.
  BilinearWeights cosines() const {
    const double b = cosine_weight(normal, corner[1]);
    return {b, b, cosine_weight(normal, corner[0]), cosine_weight(normal, corner[2])};
  }
};

SolidAnglePdf pdf_of(const Triangle& t, const Seen& seen, const Receiver& receiver,
                     const SurfacePoint& point) {
  if (seen.low) return {1 / seen.low->solid_angle_sr()};
  if (!seen.spherical)
    return pdf_seen_from(receiver.position, point, t.pdf_area(point.position), seen.height);
  const double uniform = 1 / seen.spherical->solid_angle_sr();
  if (seen.way != AreaSampling::kCosineSolidAngle) return {uniform};
  const auto [b, c] = t.shares_at(point.position);
  const Vec2 u = seen.spherical->invert({1 - b - c, b, c});
  return {uniform * seen.cosines().pdf(u)};
}

}  // namespace

double Triangle::area() const { return length(area_vector(*this)) / 2; }

Vec3 Triangle::normal() const { return normalized(area_vector(*this)); }

double Triangle::height_of(const Vec3& p) const { return height_over(p, a, b, c); }

SurfacePoint Triangle::sample_area(Vec2 u, AreaSampling way) const {
  return {at(*this, sample_triangle(way, {u.x, u.y})), normal()};
}

AreaPdf Triangle::pdf_area(const Vec3&) const { return uniform_triangle_pdf(area()); }

ShapeSample Triangle::sample(const Receiver& receiver, Vec2 u) const {
  const Seen seen(*this, receiver);
  SurfacePoint point;
  Vec3 to_point;
  if (seen.low) {
    to_point = seen.low->sample({u.x, u.y});
    point = {receiver.position + to_point, normal()};
  } else if (seen.spherical) {
    Vec2 v{u.x, u.y};
    if (seen.way == AreaSampling::kCosineSolidAngle) v = seen.cosines().sample(v);
    point = {at(*this, seen.spherical->sample(v)), normal()};
  } else {
    point = sample_area(u, seen.way);
  }
  return {point, pdf_of(*this, seen, receiver, point), to_point};
}

SolidAnglePdf Triangle::pdf(const Receiver& receiver, const SurfacePoint& point) const {
  return pdf_of(*this, Seen(*this, receiver), receiver, point);
}

std::optional<ShapeHit> Triangle::intersect(const Vec3& origin, const Vec3& direction, double t_min,
                                            double t_max) const {
  const Vec3 d(direction);
  // The axis along which the ray advances most becomes z, and a shear turns the ray into that axis.
  // Then only the signs of the edge functions decide.  Two triangles get the same number, negated,
  // for their common edge.
  const Vec3 size{std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)};
  const int kz = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  const int kx = (kz + 1) % 3;
  const int ky = (kz + 2) % 3;
  if (!(size[kz] > 0)) return std::nullopt;
  const double shear_x = d[kx] / d[kz];
  const double shear_y = d[ky] / d[kz];
  const auto sheared = [&](const Vec3& vertex) {
    const Vec3 v = vertex - origin;
    return Vec3{v[kx] - shear_x * v[kz], v[ky] - shear_y * v[kz], v[kz] / d[kz]};
  };
  const Vec3 pa = sheared(a);
  const Vec3 pb = sheared(b);
  const Vec3 pc = sheared(c);
  const double ea = pc.x * pb.y - pc.y * pb.x;
  const double eb = pa.x * pc.y - pa.y * pc.x;
  const double ec = pb.x * pa.y - pb.y * pa.x;
  const bool inside = (ea >= 0 && eb >= 0 && ec >= 0) || (ea <= 0 && eb <= 0 && ec <= 0);
  const double sum = ea + eb + ec;
  if (!inside || sum == 0) return std::nullopt;  // sum 0: seen edge-on
  const double t = (ea * pa.z + eb * pb.z + ec * pc.z) / sum;
  if (!(t > t_min && t < t_max)) return std::nullopt;
  const Vec3 p = (a * ea + b * eb + c * ec) / sum;
  return ShapeHit{t, {p, normal()}};
}

ShapeHits Triangle::hits(const Vec3& origin, const Vec3& direction, double t_min,
                         double t_max) const {
  ShapeHits found;
  if (const auto hit = intersect(origin, direction, t_min, t_max)) found.add(hit->t, hit->point);
  return found;
}

std::pair<Vec3, Vec3> Triangle::bounds() const {
  return {{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z})},
          {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}), std::max({a.z, b.z, c.z})}};
}

Vec2 Triangle::shares_at(const Vec3& position) const {
  const Vec3 from(a);
  Vec3 ab = b - from, ac = c - from, p = position - from;
  // Squares of areas overflow for edges above 1e77 and underflow for edges below 1e-77.
  const double longest = std::fmax(max_abs(ab), max_abs(ac));
  if (longest > 1e75 || longest < 1e-60) {
    if (!(longest > 0) || !std::isfinite(longest)) return {};
    const int exponent = -std::ilogb(longest);
    ab = scaled(ab, exponent), ac = scaled(ac, exponent), p = scaled(p, exponent);
  }
  const Vec3 n = cross(ab, ac);
  const double size = dot(n, n);
  if (!(size > 0)) return {};
  return {dot(cross(p, ac), n) / size, dot(cross(ab, p), n) / size};
}

double Triangle::distance_to(const Vec3& position) const {
  const Vec3 p(position), v[3] = {a, b, c};
  const Vec3 n = normalized(area_vector(*this));
  if (n == Vec3{}) return std::numeric_limits<double>::infinity();
  double distance = std::fabs(dot(p - v[0], n));
  for (int i = 0; i < 3; ++i) {
    const Vec3 outwards = normalized(cross(v[(i + 1) % 3] - v[i], n));
    distance = std::fmax(distance, dot(p - v[i], outwards));
  }
  return is_finite(p) ? distance : std::numeric_limits<double>::infinity();
}

bool Triangle::touches(const Vec3& p) const {
  if (height_of(p) != 0) return false;
  constexpr double kEdge = 1e-14;
  const auto [b_share, c_share] = shares_at(p);
  return p == b || p == c ||
         (b_share >= -kEdge && c_share >= -kEdge && b_share + c_share <= 1 + kEdge);
}

}  // namespace lucerna
