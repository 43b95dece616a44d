#include "lights/shapes/disk.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/maths/triple_product.h"
#include "lights/sampling/projected_solid_angle.h"
#include "lights/sampling/spherical_ellipse.h"

namespace lucerna {

namespace {

absl::Status check(const DiskParams& p) {
  if (!std::isfinite(p.height_m)) return refuse_field("disk", "height_m", p.height_m, "finite");
  if (auto s = check_radius("disk", p); !s.ok()) return s;
  if (!(p.inner_radius_m >= 0 && p.inner_radius_m < p.radius_m))
    return refuse_field("disk", "inner_radius_m", p.inner_radius_m,
                        fmt::format("[0, radius {})", p.radius_m));
  return check_sweep("disk", p);
}

}  // namespace

Disk::Disk(const DiskParams& params, const Vec3& origin_m)
    : Base(params, origin_m),
      normal_(
          normalized(world_from_object_.normal({0, 0, params.reverse_orientation ? -1.0 : 1.0}))) {
  // The map scales all areas of the plane as it scales the unit square.
  const double stretch =
      length(cross(world_from_object_.vector({1, 0, 0}), world_from_object_.vector({0, 1, 0})));
  area_m2_ = params.phi_max_rad / 2 * (params.radius_m - params.inner_radius_m) *
             (params.radius_m + params.inner_radius_m) * stretch;
  is_circle_ = params.inner_radius_m == 0 && params.phi_max_rad == kTurnRad &&
               params.world_from_object.uniform_scale().has_value();
}

absl::StatusOr<Disk> Disk::create(const DiskParams& params, const Vec3& origin_m) {
  if (absl::Status status = check(params); !status.ok()) return status;
  return Base::with_finite_bounds(Disk(params, origin_m), "disk", "the disk",
                                  {0, 0, params.height_m});
}

double Disk::height_of(const Vec3& p) const {
  const Vec3 x = world_from_object_.vector({1, 0, 0});
  const Vec3 y = world_from_object_.vector({0, 1, 0});
  const double height =
      height_over_edges(p, world_from_object_.point({0, 0, params_.height_m}), x, y);
  return dot(cross(x, y), normal_) < 0 ? -height : height;
}

bool Disk::touches(const Vec3& p, std::uint32_t) const {
  if (height_of(p) != 0) return false;
  // About the middle, so coordinates far from the origin lose no precision.
  const Vec3 middle = world_from_object_.point({0, 0, params_.height_m});
  const Vec3 q = object_from_world_.vector(p - middle);
  constexpr double kEdge = 1e-14;
  const double r = std::hypot(q.x, q.y);
  return r >= params_.inner_radius_m * (1 - kEdge) && r <= params_.radius_m * (1 + kEdge) &&
         (r == 0 || is_swept(q, params_.phi_max_rad));
}

std::optional<double> Disk::projected_solid_angle_sr(const Vec3& position, const Vec3& normal,
                                                     bool two_sided) const {
  if (!is_circle_) return std::nullopt;
  const double height = height_of(position);
  if (!two_sided && !(height > 0)) return 0;
  const Vec3 middle = world_from_object_.point({0, 0, params_.height_m});
  const double scale = length(world_from_object_.vector({1, 0, 0}));
  return disk_projected_solid_angle(middle - position,
                                    normalized(world_from_object_.normal({0, 0, 1})),
                                    params_.radius_m * scale, height, normal);
}

/// A disk seen by a receiver.  For whole disks, (x, y) is a unit vector in object space: from the
/// point of the plane below the receiver to the centre.
struct Disk::Seen {
  double height_m = 0;                      // of the receiver, in the world
  std::optional<SphericalEllipse> ellipse;  // nothing: sample by area
  double x = 1, y = 0;
};

auto Disk::seen_from(const Receiver& receiver) const -> Seen {
  Seen seen;
  seen.height_m = height_of(receiver.position);
  if (!is_circle_ || is_by_area(receiver.area_sampling)) return seen;
  const Vec3 r = object_from_world_.point(receiver.position);
  const double height = std::fabs(seen.height_m) / length(world_from_object_.vector({1, 0, 0}));
  const double offset = std::hypot(r.x, r.y);
  if (offset > 0) seen.x = -r.x / offset, seen.y = -r.y / offset;
  const AreaSampling way =
      way_for_disk(receiver.area_sampling, {offset - params_.radius_m, 0, height},
                   {offset + params_.radius_m, 0, height}, receiver.incomplete);
  if (!is_by_area(way)) seen.ellipse = SphericalEllipse::create(offset, height, params_.radius_m);
  return seen;
}

ShapeSample Disk::sample(const Receiver& receiver, Vec2 u) const {
  const Seen seen = seen_from(receiver);
  ShapeSample s;
  Vec3 p;
  if (seen.ellipse) {
    const auto turned = [&seen](const Vec2& q) {
      return Vec3{q.x * seen.x - q.y * seen.y, q.x * seen.y + q.y * seen.x, 0};
    };
    const SphericalEllipse::Point chosen = seen.ellipse->choose({u.x, u.y});
    p = turned(chosen.from_center);
    p.z = params_.height_m;
    // Close below the receiver, positions on the disk round by more than their distance.
    constexpr double kLow = 1e-3;
    const double scale = length(world_from_object_.vector({1, 0, 0}));
    if (std::fabs(seen.height_m) < kLow * params_.radius_m * scale)
      s.to_point =
          world_from_object_.vector(turned(chosen.from_foot)) - normalized(normal_) * seen.height_m;
  } else {
    // Equal shares of r^2 have equal areas.  A concentric map would distort less, but does not fit
    // an annulus or a sector.
    const double inner = params_.inner_radius_m;
    const double r =
        std::sqrt(inner * inner + u.x * ((params_.radius_m - inner) * (params_.radius_m + inner)));
    const double phi = params_.phi_max_rad * u.y;
    p = on_ring(r, phi, params_.height_m);
  }
  s.point = surface_point(p);
  s.pdf = pdf(seen, receiver, s.point);
  return s;
}

SolidAnglePdf Disk::pdf(const Seen& seen, const Receiver& receiver,
                        const SurfacePoint& point) const {
  if (!seen.ellipse)
    return pdf_seen_from(receiver.position, point, AreaPdf{1 / area_m2_}, seen.height_m);
  const Vec3 p = object_from_world_.point(point.position);
  const Vec2 q{p.x * seen.x + p.y * seen.y, p.y * seen.x - p.x * seen.y};
  return {seen.ellipse->pdf(q)};
}

SolidAnglePdf Disk::pdf(const Receiver& receiver, const SurfacePoint& point) const {
  return pdf(seen_from(receiver), receiver, point);
}

int Disk::roots(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
                QuadricRoots& out) const {
  const Vec3 o = object_from_world_.point(origin);
  const Vec3 d = object_from_world_.vector(direction);
  if (d.z == 0) return 0;
  const double t = (params_.height_m - o.z) / d.z;
  if (!(t > t_min && t < t_max)) return 0;
  const double x = o.x + d.x * t;
  const double y = o.y + d.y * t;
  const double r2 = x * x + y * y;
  if (!(r2 <= params_.radius_m * params_.radius_m)) return 0;
  if (r2 < params_.inner_radius_m * params_.inner_radius_m) return 0;
  const Vec3 p{x, y, params_.height_m};
  if (!is_swept(p, params_.phi_max_rad)) return 0;
  out[0] = {t, p};
  return 1;
}

std::pair<Vec3, Vec3> Disk::bounds() const {
  const auto& m = world_from_object_.matrix();
  const Vec3 center = world_from_object_.point({0, 0, params_.height_m});
  // The extent of an ellipse along an axis is the length of that row of the map.
  const auto extent = [&](int row) {
    return params_.radius_m * length(Vec3{m[row][0], m[row][1], 0});
  };
  const Vec3 half{extent(0), extent(1), extent(2)};
  return rounded_outwards(center - half, center + half);
}

std::optional<Vec3> Disk::nearest(const Vec3& p) const {
  Vec3 q{p.x, p.y, params_.height_m};
  const double r = std::hypot(q.x, q.y);
  const double ring = std::clamp(r, params_.inner_radius_m, params_.radius_m);
  if (!is_finite(q) || (r == 0 && ring > 0)) return std::nullopt;
  if (ring != r) q = {q.x * (ring / r), q.y * (ring / r), q.z};
  return q;
}

NormalCone Disk::normals() const { return {normal_, 0}; }

Vec2 Disk::uv(const SurfacePoint& point) const {
  const Vec3 p = object_from_world_.point(point.position);
  const double v =
      (params_.radius_m - std::hypot(p.x, p.y)) / (params_.radius_m - params_.inner_radius_m);
  return {share_of_sweep(p, params_.phi_max_rad), std::clamp(v, 0.0, 1.0)};
}

BandArea Disk::area_of(const Band& band) const {
  // The radius grows downwards, from the inner edge, and area with its square.
  const double inner = params_.inner_radius_m, ring = params_.radius_m - inner;
  const double middle = inner + ring * (band.above + band.height / 2);
  const double per_whole = band.height / ((params_.radius_m + inner) / 2);
  return {middle * per_whole, ring * band.height / 6 * per_whole};
}

SurfacePoint Disk::at_shares(Vec2 shares) const {
  const double inner = params_.inner_radius_m;
  const double r = std::sqrt(
      inner * inner + (1 - shares.y) * ((params_.radius_m - inner) * (params_.radius_m + inner)));
  const double phi = params_.phi_max_rad * shares.x;
  return surface_point(on_ring(r, phi, params_.height_m));
}

}  // namespace lucerna
