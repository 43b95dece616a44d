#include "lights/shapes/sphere.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lights/sampling/projected_solid_angle.h"
#include "lights/sampling/sampling.h"
#include "lights/shapes/seen_sphere.h"

namespace lucerna {

namespace {

absl::Status check(const SphereParams& p) {
  if (auto s = check_radius("sphere", p); !s.ok()) return s;
  if (auto s = check_sweep("sphere", p); !s.ok()) return s;
  if (!(p.z_min_m < p.radius_m))
    return refuse_field("sphere", "z_min_m", p.z_min_m,
                        fmt::format("less than the radius, {}", p.radius_m));
  if (!(p.z_max_m > -p.radius_m))
    return refuse_field("sphere", "z_max_m", p.z_max_m, fmt::format("more than {}", -p.radius_m));
  if (!(p.z_max_m > p.z_min_m))
    return refuse_field("sphere", "z_max_m", p.z_max_m,
                        fmt::format("more than z_min_m, {}", p.z_min_m));
  return absl::OkStatus();
}

/// The polar angle from +z of the circle at height `z` of a sphere.
double polar_angle(double z, double radius) {
  return std::atan2(std::sqrt((radius - z) * (radius + z)), z);
}

/// sin(h) / h - cos(h) for h in [0, pi / 2].  Uses its series where the difference cancels.
double sinc_minus_cos(double h) {
  if (h > 0.5) return std::sin(h) / h - std::cos(h);
  double sum = 0, term = 1;  // term: (-h^2)^k / (2 k + 1)!
  for (int k = 1; k <= 8; ++k) {
    term *= -h * h / (2 * k * (2 * k + 1));
    sum -= 2 * k * term;
  }
  return sum;
}

}  // namespace

Sphere::Sphere(const SphereParams& params, const Vec3& origin_m)
    : Base(params, origin_m),
      z_min_m_(std::max(params.z_min_m, -params.radius_m)),
      z_max_m_(std::min(params.z_max_m, params.radius_m)),
      is_cut_in_z_(z_min_m_ > -params.radius_m || z_max_m_ < params.radius_m),
      is_cut_in_phi_(params.phi_max_rad < kTurnRad),
      is_whole_(!is_cut_in_z_ && !is_cut_in_phi_),
      center_m_(world_from_object_.point({0, 0, 0})) {
  if (const auto scale = params.world_from_object.uniform_scale()) {
    world_radius_m_ = params.radius_m * *scale;
    area_m2_ = params.phi_max_rad * world_radius_m_ * (z_max_m_ - z_min_m_) * *scale;
  }
}

absl::StatusOr<Sphere> Sphere::create(const SphereParams& params, const Vec3& origin_m) {
  if (absl::Status status = check(params); !status.ok()) return status;
  return Base::with_finite_bounds(Sphere(params, origin_m), "sphere", "the sphere", {0, 0, 0});
}

absl::Status Sphere::emissive_error() const {
  if (world_radius_m_ > 0) return absl::OkStatus();
  return this->refuse_map("sphere", "equal factors, no shear");
}

typename Sphere::Way Sphere::way_at(double distance, const Receiver& receiver) const {
  if (!is_whole_) return Way::kArea;
  if (is_by_area(way_for_sphere(receiver.area_sampling))) return Way::kArea;
  if (distance > world_radius_m_) return Way::kCone;
  // Closer to the surface, floats cannot separate half of the sampled points from the receiver.
  constexpr double kDepth = 1e-3;
  return distance < (1 - kDepth) * world_radius_m_ ? Way::kInside : Way::kArea;
}

ShapeSample Sphere::sample(const Receiver& receiver, Vec2 u) const {
  const Vec3 to_center = center_m_ - receiver.position;
  const SeenSphere seen{to_center, length(to_center), world_radius_m_};
  const Way way = way_at(seen.distance, receiver);
  if (way != Way::kArea) {
    const bool is_outside = way == Way::kCone;
    const Vec2 v{u.x, u.y};
    const SeenSphere::Point p = is_outside ? seen.from_outside(v) : seen.from_within(v);
    ShapeSample s;
    s.point.position = center_m_ + p.from_center;
    s.point.normal = params_.reverse_orientation ? -p.normal : p.normal;
    s.pdf = {p.pdf_per_sr};
    s.to_point = p.to_point;
    return s;
  }

  // Equal shares of z have equal areas (Archimedes), for any cuts.
  const double z = std::min(z_min_m_ + (z_max_m_ - z_min_m_) * u.x, z_max_m_);
  const double phi = params_.phi_max_rad * u.y;
  const double ring = std::sqrt((params_.radius_m - z) * (params_.radius_m + z));
  ShapeSample s;
  s.point = surface_point(on_ring(ring, phi, z));
  s.pdf = pdf_by_area(receiver, s.point);
  return s;
}

SolidAnglePdf Sphere::pdf(const Receiver& receiver, const SurfacePoint& point) const {
  const Vec3 to_receiver = receiver.position - center_m_;
  const double distance = length(to_receiver);
  const Way way = way_at(distance, receiver);
  if (way == Way::kArea) return pdf_by_area(receiver, point);
  if (way == Way::kInside) return uniform_sphere_pdf();
  // The normal decides whether the point is on the near side.  It gives the place on the sphere
  // exactly, even far from the origin.  The bound is lowered by the rounding of both vectors, so
  // that no sample at the rim is lost.
  constexpr double kRounding = 4 * kInputRounding;
  const Vec3 n(point.normal);
  const double cos_alpha = dot(params_.reverse_orientation ? -n : n, to_receiver) / distance;
  if (!(cos_alpha >= world_radius_m_ / distance - kRounding)) return {0};
  return {SeenSphere{-to_receiver, distance, world_radius_m_}.pdf_from_outside()};
}

int Sphere::roots(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
                  QuadricRoots& out) const {
  const double r = params_.radius_m;
  const Vec3 o = object_from_world_.point(origin);
  const Vec3 d = object_from_world_.vector(direction);
  const double dd = dot(d, d);
  if (!(dd > 0)) return 0;
  // Computes the discriminant from the point of closest approach.  b^2 - 4 a c would cancel for far
  // origins and small spheres.  [Haines19]
  const double closest = -dot(o, d) / dd;
  const Vec3 approach = o + d * closest;
  const double approach_distance = std::sqrt(dot(approach, approach));
  if (!(approach_distance <= r)) return 0;
  const double half_chord = std::sqrt((r - approach_distance) * (r + approach_distance) / dd);
  const auto [first, second] = Base::roots_of(closest, half_chord, std::sqrt(dot(o, o)), r, dd);

  const Vec3 step = d * half_chord;
  int count = 0;
  const auto add = [&](double t, const Vec3& near_surface) {
    if (!(t > t_min && t < t_max)) return;
    const Vec3 p = near_surface * (r / std::sqrt(dot(near_surface, near_surface)));
    if (!is_cut_away(p)) out[count++] = {t, p};
  };
  add(first, approach - step);
  add(second, approach + step);
  return count;
}

bool Sphere::is_cut_away(const Vec3& p) const {
  if (is_cut_in_z_ && (p.z < z_min_m_ || p.z > z_max_m_)) return true;
  return !is_swept(p, params_.phi_max_rad);
}

std::pair<Vec3, Vec3> Sphere::bounds() const {
  const auto& m = world_from_object_.matrix();
  // The widest ring of a cut sphere, for its box.
  const double r = params_.radius_m;
  const double z = std::clamp(0.0, z_min_m_, z_max_m_);
  const double ring = std::sqrt((r - z) * (r + z));
  const double z_middle = (z_min_m_ + z_max_m_) / 2;
  const double z_half = (z_max_m_ - z_min_m_) / 2;
  const auto extent = [&](int row) {
    // Two bounds are valid: the whole ellipsoid, and the image of the box around the remaining
    // part.
    const double ellipsoid = r * length(Vec3{m[row][0], m[row][1], m[row][2]});
    const double box =
        ring * (std::fabs(m[row][0]) + std::fabs(m[row][1])) + z_half * std::fabs(m[row][2]);
    const double middle = m[row][3] + m[row][2] * z_middle;
    return std::pair{std::max(m[row][3] - ellipsoid, middle - box),
                     std::min(m[row][3] + ellipsoid, middle + box)};
  };
  const auto x = extent(0);
  const auto y = extent(1);
  const auto w = extent(2);
  return rounded_outwards({x.first, y.first, w.first}, {x.second, y.second, w.second});
}

std::optional<Vec3> Sphere::nearest(const Vec3& p) const {
  const double r = params_.radius_m;
  Vec3 q = normalized(p) * r;
  if (!is_finite(q)) return std::nullopt;
  if (q.z < z_min_m_ || q.z > z_max_m_) {
    const double z = std::clamp(q.z, z_min_m_, z_max_m_);
    const double to_ring = std::sqrt((r - z) * (r + z)) / std::hypot(q.x, q.y);
    q = {q.x * to_ring, q.y * to_ring, z};
  }
  return q;
}

NormalCone Sphere::normals() const {
  if (!is_cut_in_z_) return {};
  // A cone about +z from the lower cut, or about -z from the upper cut; use the narrower one.
  const double up = polar_angle(z_min_m_, params_.radius_m);
  const double down = polar_angle(-z_max_m_, params_.radius_m);
  const bool is_up = up <= down;
  const Vec3 axis = world_from_object_.normal({0, 0, is_up ? 1.0 : -1.0});
  return {normalized(params_.reverse_orientation ? -axis : axis),
          std::min(std::min(up, down) + kNormalSlackRad, std::numbers::pi)};
}

Vec2 Sphere::uv(const SurfacePoint& point) const {
  const Vec3 p = object_from_world_.point(point.position);
  // atan2: the arccosine of z loses half of its digits near the poles.
  const double theta = std::atan2(std::hypot(p.x, p.y), p.z);
  const double bottom = polar_angle(z_min_m_, params_.radius_m);
  const double top = polar_angle(z_max_m_, params_.radius_m);
  const double v = top == bottom ? 0.5 : std::clamp((theta - bottom) / (top - bottom), 0.0, 1.0);
  return {share_of_sweep(p, params_.phi_max_rad), v};
}

BandArea Sphere::area_of(const Band& band) const {
  // Polar angles are from the pole nearer to the middle.  Differences of cosines are products:
  // cos(m - h) - cos(m + h) = 2 sin m sin h.
  const double r = params_.radius_m;
  const double top = polar_angle(z_max_m_, r), bottom = polar_angle(-z_min_m_, r);
  const bool is_northern = z_min_m_ + z_max_m_ >= 0;
  const double sweep =
      is_northern ? polar_angle(z_min_m_, r) - top : polar_angle(-z_max_m_, r) - bottom;
  struct Middle {
    double sin, cos;
  };
  const auto middle_of = [&](const Band& b) -> Middle {
    const double from_top = top + (b.above + b.height / 2) * sweep;
    if (from_top <= std::numbers::pi / 2) return {std::sin(from_top), std::cos(from_top)};
    const double from_bottom = bottom + (b.below + b.height / 2) * sweep;
    return {std::sin(from_bottom), -std::cos(from_bottom)};
  };
  const double whole = middle_of({0, 1, 0}).sin * std::sin(sweep / 2);
  // The zone is so thin that its angles coincide: a cylinder is as exact.
  if (!(whole > 0)) return {band.height, 0};
  const double half = band.height * sweep / 2;
  const Middle middle = middle_of(band);
  // The integral of x sin(m + h x) from -1 to 1 is 2 cos(m) (sin(h) / h - cos(h)) / h.
  return {middle.sin * std::sin(half) / whole, middle.cos * sinc_minus_cos(half) / whole};
}

SurfacePoint Sphere::at_shares(Vec2 shares) const {
  const double z = std::clamp(std::lerp(z_min_m_, z_max_m_, shares.y), z_min_m_, z_max_m_);
  const double phi = params_.phi_max_rad * shares.x;
  const double ring = std::sqrt((params_.radius_m - z) * (params_.radius_m + z));
  return surface_point(on_ring(ring, phi, z));
}

std::optional<double> Sphere::projected_solid_angle_sr(const Vec3& position, const Vec3& normal,
                                                       bool two_sided) const {
  if (!is_whole_ || touches(position)) return std::nullopt;
  const Vec3 to_center = center_m_ - position;
  const double r = world_radius_m_, d = length(to_center);
  const bool is_inside = d < r;
  if (!two_sided && is_inside != params_.reverse_orientation) return 0;
  if (is_inside) return std::numbers::pi;
  return cap_projected_solid_angle(to_center / d, r / d,
                                   std::sqrt((d - r) / d) * std::sqrt((d + r) / d), normal);
}

bool Sphere::touches(const Vec3& p, std::uint32_t) const {
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  const Vec3 from_center = p - center_m_;
  return std::fabs(length(from_center) - world_radius_m_) <= kRounding * world_radius_m_ &&
         (is_whole_ || !is_cut_away(object_from_world_.vector(from_center)));
}

}  // namespace lucerna
