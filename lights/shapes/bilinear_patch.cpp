#include "lights/shapes/bilinear_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lights/maths/triple_product.h"
#include "lights/sampling/sampling.h"
#include "lights/sampling/spherical_fan.h"
#include "lights/sampling/spherical_rectangle.h"
#include "lights/shapes/bilinear_form.h"
#include "lights/shapes/bilinear_inverse.h"

namespace lucerna {

namespace {

/// The sampling density in (u, v): proportional to |dp/du x dp/dv| at the corners, bilinear between
/// them.  By the triangle inequality it is positive wherever the patch has area.
struct CornerWeights : BilinearWeights {
  bool flat_convex;

  explicit CornerWeights(const BilinearForm& p) {
    if (p.g == Vec3{}) {  // a parallelogram, as most are
      w00 = w10 = w01 = w11 = length(cross(p.e, p.f));
      flat_convex = w00 > 0;
      return;
    }
    const Vec3 n[4] = {p.area_vector(0, 0), p.area_vector(1, 0), p.area_vector(0, 1),
                       p.area_vector(1, 1)};
    w00 = length(n[0]), w10 = length(n[1]), w01 = length(n[2]), w11 = length(n[3]);
    // Normals that differ by an angle a change the area by a^2 / 2.  Rounding corners to float
    // turns normals by 1e-7.
    constexpr double kFlat = 1e-6;
    const Vec3 sum = (n[0] + n[1]) + (n[2] + n[3]);
    // Scaled to length 1 first, because squares of areas leave double's range.  If the halves of a
    // patch cancel, the sum is 0 and gives NaN, which counts as not flat.
    const double to_unit = 1 / length(sum);
    const Vec3 side = sum * to_unit;
    flat_convex = true;
    for (const auto& corner : n) {
      const Vec3 c = corner * to_unit, off = cross(c, side);
      flat_convex = flat_convex && dot(c, side) >= -kFlat && dot(off, off) <= kFlat * kFlat;
    }
  }
};

SurfacePoint sample_area(const BilinearForm& p, const CornerWeights& weights, Vec2 u) {
  const auto [s, t] = weights.sample({u.x, u.y});
  return {p.at(s, t), normalized(p.area_vector(s, t))};
}

AreaPdf pdf_area(const BilinearPatch& patch, const BilinearForm& p, const CornerWeights& weights,
                 const Vec3& position) {
  const double uniform = 1 / weights.mean();
  if (weights.flat_convex) return {uniform};
  const auto [lower, upper] = patch.bounds();
  const double tolerance_m =
      8 * kInputRounding * (static_cast<double>(max_abs(lower)) + max_abs(upper));
  Vec2 uv[2];
  const int count = invert(p, position, tolerance_m, uv);
  double sum = 0;
  for (int i = 0; i < count; ++i)
    sum += weights.at(uv[i].x, uv[i].y) / length(p.area_vector(uv[i].x, uv[i].y));
  return {sum * uniform};
}

/// The corners' weights are computed once for a point and its density.
ShapeSample sample_area_from(const BilinearPatch& patch, const BilinearForm& p,
                             const Receiver& receiver, Vec2 u) {
  const CornerWeights weights(p);
  const SurfacePoint point = sample_area(p, weights, u);
  return {point,
          pdf_seen_from(receiver.position, point, pdf_area(patch, p, weights, point.position))};
}

}  // namespace

BilinearPatchArea BilinearPatch::measure() const {
  const BilinearForm p(*this);
  const CornerWeights weights(p);
  if (weights.flat_convex) return {weights.mean(), 0};
  constexpr double kRelative = 1e-8;
  return integrate_area(p, kRelative * weights.mean());
}

Vec3 BilinearPatch::at(Vec2 uv) const { return BilinearForm(*this).at(uv.x, uv.y); }

Vec3 BilinearPatch::normal(Vec2 uv) const {
  return normalized(BilinearForm(*this).area_vector(uv.x, uv.y));
}

SurfacePoint BilinearPatch::sample_area(Vec2 u) const {
  const BilinearForm p(*this);
  return lucerna::sample_area(p, CornerWeights(p), u);
}

double BilinearPatch::area_element(Vec2 uv) const {
  return length(BilinearForm(*this).area_vector(uv.x, uv.y));
}

double BilinearPatch::least_area_element() const {
  const BilinearForm p(*this);
  const Vec3 n[4] = {p.area_vector(0, 0), p.area_vector(1, 0), p.area_vector(0, 1),
                     p.area_vector(1, 1)};
  const Vec3 side = normalized((n[0] + n[1]) + (n[2] + n[3]));
  return std::max(0.0,
                  std::min({dot(n[0], side), dot(n[1], side), dot(n[2], side), dot(n[3], side)}));
}

bool BilinearPatch::is_unfolded() const {
  const BilinearForm p(*this);
  const Vec3 n[4] = {p.area_vector(0, 0), p.area_vector(1, 0), p.area_vector(0, 1),
                     p.area_vector(1, 1)};
  const Vec3 sum = (n[0] + n[1]) + (n[2] + n[3]);
  const Vec3 side = normalized(sum);
  // A corner without area, as in a triangle, is not a fold, but it has no density.
  constexpr double kLeast = 1e-6;
  for (const auto& corner : n)
    if (!(dot(corner, side) > kLeast * length(sum))) return false;
  return true;
}

bool BilinearPatch::is_rectangle() const {
  const BilinearForm p(*this);
  const double x = length(p.e);
  const double y = length(p.f);
  // The tolerance is the rounding of float corners at a distance of eight times the patch's size.
  // A patch that counts as a rectangle has no larger error in its density.
  constexpr double kSquare = 1e-6;
  return x > 0 && y > 0 && std::fabs(dot(p.e / x, p.f / y)) <= kSquare &&
         length(p.g) <= kSquare * std::fmin(x, y);
}

namespace {

/// A rectangle seen by a receiver, and how its points are chosen.
struct Seen {
  Vec3 corner[4];  // 00, 10, 01, 11; from the receiver
  Vec3 normal;     // the receiver's
  double height;   // of the receiver
  AreaSampling way;
  std::optional<SphericalFan> fan;  // comes first
  std::optional<SphericalRectangle> spherical;

  Seen(const BilinearPatch& patch, const BilinearForm& p, const Receiver& receiver)
      : normal(receiver.normal), height(patch.height_of(receiver.position)) {
    const Vec3 r(receiver.position);
    for (int i = 0; i < 4; ++i) corner[i] = p.at(i & 1, i >> 1) - r;
    way = way_for_corners(receiver.area_sampling, corner, normal, receiver.incomplete);
    if (is_by_area(way) || height == 0) return;
    const Vec3 around[] = {corner[0], corner[1], corner[3], corner[2]};
    if (SphericalFan::is_low(around, height))
      fan = SphericalFan::create(around, normalized(cross(p.e, p.f)), height);
    if (!fan) spherical = SphericalRectangle::create(corner[0], p.e, p.f, height);
  }

  BilinearWeights cosines() const {
    const auto weight = [&](int i) { return cosine_weight(normal, corner[i]); };
    return {weight(0), weight(1), weight(2), weight(3)};
  }
};

SolidAnglePdf pdf_of(const BilinearPatch& patch, const BilinearForm& p, const Seen& seen,
                     const Receiver& receiver, const SurfacePoint& point) {
  if (seen.fan) return {1 / seen.fan->solid_angle_sr()};
  if (!seen.spherical)
    return pdf_seen_from(receiver.position, point, patch.pdf_area(point.position), seen.height);
  const double uniform = 1 / seen.spherical->solid_angle_sr();
  if (seen.way != AreaSampling::kCosineSolidAngle) return {uniform};
  const Vec3 q = point.position - p.p00;
  const Vec2 shares{dot(q, p.e) / dot(p.e, p.e), dot(q, p.f) / dot(p.f, p.f)};
  return {uniform * seen.cosines().pdf(seen.spherical->invert(shares))};
}

}  // namespace

bool BilinearPatch::is_flat() const {
  const BilinearForm form(*this);
  if (!CornerWeights(form).flat_convex || !(length(cross(form.e, form.f)) > 0)) return false;
  // One rounding of each coordinate of each corner.
  const auto [lower, upper] = bounds();
  const double rounding =
      4 * std::numeric_limits<double>::epsilon() * (double{max_abs(lower)} + max_abs(upper));
  return std::fabs(height_over(p11, p00, p10, p01)) <= rounding;
}

double BilinearPatch::height_of(const Vec3& p) const {
  if (p == p11) return 0;  // rounding may have moved it off the plane of the others
  return height_over(p, p00, p10, p01);
}

bool BilinearPatch::touches(const Vec3& p) const {
  if (height_of(p) != 0) return false;
  if (p == p10 || p == p01 || p == p11) return true;
  const BilinearForm form(*this);
  const Vec3 side = normalized(cross(form.e, form.f));
  const Vec3 around[] = {p00, p10, p11, p01};
  const double edge = 1e-14 * (length(form.e) + length(form.f));
  for (int i = 0; i < 4; ++i) {
    const Vec3 way = around[(i + 1) % 4] - around[i];
    if (way == Vec3{}) continue;
    if (dot(cross(normalized(way), p - around[i]), side) < -edge) return false;
  }
  return true;
}

ShapeSample BilinearPatch::sample(const Receiver& receiver, Vec2 u) const {
  const BilinearForm p(*this);
  const Seen seen(*this, p, receiver);
  SurfacePoint point;
  Vec3 to_point;
  if (seen.fan) {
    to_point = seen.fan->sample({u.x, u.y});
    point = {receiver.position + to_point, normalized(cross(p.e, p.f))};
  } else if (seen.spherical) {
    Vec2 v{u.x, u.y};
    if (seen.way == AreaSampling::kCosineSolidAngle) v = seen.cosines().sample(v);
    const auto [s, t] = seen.spherical->sample(v);
    point = {p.at(s, t), normalized(p.area_vector(s, t))};
  } else {
    point = lucerna::sample_area(p, CornerWeights(p), u);
  }
  return {point, pdf_of(*this, p, seen, receiver, point), to_point};
}

ShapeSample BilinearPatch::sample_area(const Receiver& receiver, Vec2 u) const {
  return sample_area_from(*this, BilinearForm(*this), receiver, u);
}

SolidAnglePdf BilinearPatch::pdf(const Receiver& receiver, const SurfacePoint& point) const {
  const BilinearForm p(*this);
  return pdf_of(*this, p, Seen(*this, p, receiver), receiver, point);
}

AreaPdf BilinearPatch::pdf_area(const Vec3& position) const {
  const BilinearForm p(*this);
  return lucerna::pdf_area(*this, p, CornerWeights(p), position);
}

ShapeHits BilinearPatch::hits(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
                              std::array<Vec2, 2>* uv_hits) const {
  const BilinearForm p(*this);
  const Vec3 d(direction);
  const double dd = dot(d, d);
  ShapeHits found;
  if (!(dd > 0)) return found;
  // Start from the point of the ray nearest to a corner, so that far origins do not cancel below.
  const double t_near = dot(p.p00 - origin, d) / dd;
  const Vec3 a = p.p00 - (origin + d * t_near);

  // The line of constant u meets the ray's line where a + u e, f + u g and d lie in one plane.
  const Vec3 fd = cross(p.f, d);
  const Vec3 gd = cross(p.g, d);
  double root[2];
  const int count = solve_quadratic(dot(p.e, gd), dot(p.e, fd) + dot(a, gd), dot(a, fd), root);

  // Edges belong to the patch.  Rounding in double may put (u, v) beyond them by this much.
  constexpr double kEdge = 1e-10;
  const auto on_patch = [](double x) { return x >= -kEdge && x <= 1 + kEdge; };
  double t_of[2];
  for (int i = 0; i < count; ++i) {
    if (!on_patch(root[i])) continue;
    const double u = std::clamp(root[i], 0.0, 1.0);
    const Vec3 line = p.f + p.g * u;
    const Vec3 w = a + p.e * u;  // t d - v line = w
    const Vec3 n = cross(d, line);
    const double nn = dot(n, n);
    if (!(nn > 0)) continue;
    const double v = dot(cross(w, d), n) / nn;
    const double t = t_near + dot(cross(w, line), n) / nn;
    if (!on_patch(v) || !(t > t_min && t < t_max)) continue;
    const Vec2 uv{u, std::clamp(v, 0.0, 1.0)};
    const SurfacePoint point{p.at(u, std::clamp(v, 0.0, 1.0)), normalized(p.area_vector(u, v))};
    t_of[found.count] = t;
    if (uv_hits) (*uv_hits)[found.count] = uv;
    found.add(t, point);
  }
  if (found.count == 2 && t_of[1] < t_of[0]) {
    std::swap(found.hit[0], found.hit[1]);
    if (uv_hits) std::swap((*uv_hits)[0], (*uv_hits)[1]);
  }
  return found;
}

std::optional<ShapeHit> BilinearPatch::intersect(const Vec3& origin, const Vec3& direction,
                                                 double t_min, double t_max, Vec2* uv_hit) const {
  std::array<Vec2, 2> uv;
  const auto found = hits(origin, direction, t_min, t_max, &uv);
  if (found.count == 0) return std::nullopt;
  if (uv_hit) *uv_hit = uv[0];
  return found.hit[0];
}

std::pair<Vec3, Vec3> BilinearPatch::bounds() const {
  return {{std::min({p00.x, p10.x, p01.x, p11.x}), std::min({p00.y, p10.y, p01.y, p11.y}),
           std::min({p00.z, p10.z, p01.z, p11.z})},
          {std::max({p00.x, p10.x, p01.x, p11.x}), std::max({p00.y, p10.y, p01.y, p11.y}),
           std::max({p00.z, p10.z, p01.z, p11.z})}};
}

Vec2 BilinearPatch::locate(const Vec3& position) const {
  const Vec2 uv = nearest(BilinearForm(*this), position);
  return {uv.x, uv.y};
}

}  // namespace lucerna
