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

template <typename Real>
Disk<Real>::Disk(const DiskParams& params, const Vec3<double>& origin_m)
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

template <typename Real>
absl::StatusOr<Disk<Real>> Disk<Real>::create(const DiskParams& params,
                                              const Vec3<double>& origin_m) {
  if (absl::Status status = check(params); !status.ok()) return status;
  return Base::with_finite_bounds(Disk(params, origin_m), "disk", "the disk",
                                  {0, 0, params.height_m});
}

template <typename Real>
double Disk<Real>::height_of(const Vec3<Real>& p) const {
  const Vec3<double> x = world_from_object_.vector({1, 0, 0});
  const Vec3<double> y = world_from_object_.vector({0, 1, 0});
  const double height =
      height_over_edges(Vec3<double>(p), world_from_object_.point({0, 0, params_.height_m}), x, y);
  return dot(cross(x, y), Vec3<double>(normal_)) < 0 ? -height : height;
}

template <typename Real>
bool Disk<Real>::touches(const Vec3<Real>& p, std::uint32_t) const {
  if (height_of(p) != 0) return false;
  // About the middle, so coordinates far from the origin lose no precision.
  const Vec3<double> middle = world_from_object_.point({0, 0, params_.height_m});
  const Vec3<double> q = object_from_world_.vector(Vec3<double>(p) - middle);
  constexpr double kEdge = 1e-14;
  const double r = std::hypot(q.x, q.y);
  return r >= params_.inner_radius_m * (1 - kEdge) && r <= params_.radius_m * (1 + kEdge) &&
         (r == 0 || is_swept(q, params_.phi_max_rad));
}

template <typename Real>
std::optional<double> Disk<Real>::projected_solid_angle_sr(const Vec3<Real>& position,
                                                           const Vec3<double>& normal,
                                                           bool two_sided) const {
  if (!is_circle_) return std::nullopt;
  const double height = height_of(position);
  if (!two_sided && !(height > 0)) return 0;
  const Vec3<double> middle = world_from_object_.point({0, 0, params_.height_m});
  const double scale = length(world_from_object_.vector({1, 0, 0}));
  return disk_projected_solid_angle(middle - Vec3<double>(position),
                                    normalized(world_from_object_.normal({0, 0, 1})),
                                    params_.radius_m * scale, height, normal);
}

/// A disk seen by a receiver.  For whole disks, (x, y) is a unit vector in object space: from the
/// point of the plane below the receiver to the centre.
template <typename Real>
struct Disk<Real>::Seen {
  double height_m = 0;                      // of the receiver, in the world
  std::optional<SphericalEllipse> ellipse;  // nothing: sample by area
  double x = 1, y = 0;
};

template <typename Real>
auto Disk<Real>::seen_from(const Receiver<Real>& receiver) const -> Seen {
  Seen seen;
  seen.height_m = height_of(receiver.position);
  if (!is_circle_ || is_by_area(receiver.area_sampling)) return seen;
  const Vec3<double> r = object_from_world_.point(Vec3<double>(receiver.position));
  const double height = std::fabs(seen.height_m) / length(world_from_object_.vector({1, 0, 0}));
  const double offset = std::hypot(r.x, r.y);
  if (offset > 0) seen.x = -r.x / offset, seen.y = -r.y / offset;
  const AreaSampling way =
      way_for_disk(receiver.area_sampling, {offset - params_.radius_m, 0, height},
                   {offset + params_.radius_m, 0, height}, receiver.incomplete);
  if (!is_by_area(way)) seen.ellipse = SphericalEllipse::create(offset, height, params_.radius_m);
  return seen;
}

template <typename Real>
ShapeSample<Real> Disk<Real>::sample(const Receiver<Real>& receiver, Vec2<Real> u) const {
  const Seen seen = seen_from(receiver);
  ShapeSample<Real> s;
  Vec3<double> p;
  if (seen.ellipse) {
    const auto turned = [&seen](const Vec2<double>& q) {
      return Vec3<double>{q.x * seen.x - q.y * seen.y, q.x * seen.y + q.y * seen.x, 0};
    };
    const SphericalEllipse::Point chosen = seen.ellipse->choose({u.x, u.y});
    p = turned(chosen.from_center);
    p.z = params_.height_m;
    // Close below the receiver, positions on the disk round by more than their distance.
    constexpr double kLow = 1e-3;
    const double scale = length(world_from_object_.vector({1, 0, 0}));
    if (std::fabs(seen.height_m) < kLow * params_.radius_m * scale)
      s.to_point = world_from_object_.vector(turned(chosen.from_foot)) -
                   normalized(Vec3<double>(normal_)) * seen.height_m;
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

template <typename Real>
SolidAnglePdf<Real> Disk<Real>::pdf(const Seen& seen, const Receiver<Real>& receiver,
                                    const SurfacePoint<Real>& point) const {
  if (!seen.ellipse)
    return as_seen_from(receiver.position, point, AreaPdf<double>{1 / area_m2_}, seen.height_m);
  const Vec3<double> p = object_from_world_.point(Vec3<double>(point.position));
  const Vec2<double> q{p.x * seen.x + p.y * seen.y, p.y * seen.x - p.x * seen.y};
  return {static_cast<Real>(seen.ellipse->pdf(q))};
}

template <typename Real>
SolidAnglePdf<Real> Disk<Real>::pdf(const Receiver<Real>& receiver,
                                    const SurfacePoint<Real>& point) const {
  return pdf(seen_from(receiver), receiver, point);
}

template <typename Real>
int Disk<Real>::roots(const Vec3<Real>& origin, const Vec3<Real>& direction, Real t_min, Real t_max,
                      QuadricRoots& out) const {
  const Vec3<double> o = object_from_world_.point(Vec3<double>(origin));
  const Vec3<double> d = object_from_world_.vector(Vec3<double>(direction));
  if (d.z == 0) return 0;
  const double t = (params_.height_m - o.z) / d.z;
  if (!(t > t_min && t < t_max)) return 0;
  const double x = o.x + d.x * t;
  const double y = o.y + d.y * t;
  const double r2 = x * x + y * y;
  if (!(r2 <= params_.radius_m * params_.radius_m)) return 0;
  if (r2 < params_.inner_radius_m * params_.inner_radius_m) return 0;
  const Vec3<double> p{x, y, params_.height_m};
  if (!is_swept(p, params_.phi_max_rad)) return 0;
  out[0] = {t, p};
  return 1;
}

template <typename Real>
std::pair<Vec3<Real>, Vec3<Real>> Disk<Real>::bounds() const {
  const auto& m = world_from_object_.matrix();
  const Vec3<double> center = world_from_object_.point({0, 0, params_.height_m});
  // The extent of an ellipse along an axis is the length of that row of the map.
  const auto extent = [&](int row) {
    return params_.radius_m * length(Vec3<double>{m[row][0], m[row][1], 0});
  };
  const Vec3<double> half{extent(0), extent(1), extent(2)};
  return rounded_outwards<Real>(center - half, center + half);
}

template <typename Real>
std::optional<Vec3<double>> Disk<Real>::nearest(const Vec3<double>& p) const {
  Vec3<double> q{p.x, p.y, params_.height_m};
  const double r = std::hypot(q.x, q.y);
  const double ring = std::clamp(r, params_.inner_radius_m, params_.radius_m);
  if (!is_finite(q) || (r == 0 && ring > 0)) return std::nullopt;
  if (ring != r) q = {q.x * (ring / r), q.y * (ring / r), q.z};
  return q;
}

template <typename Real>
NormalCone<Real> Disk<Real>::normals() const {
  return {normal_, 0};
}

template <typename Real>
Vec2<double> Disk<Real>::uv(const Vec3<Real>& position) const {
  const Vec3<double> p = object_from_world_.point(Vec3<double>(position));
  const double v =
      (params_.radius_m - std::hypot(p.x, p.y)) / (params_.radius_m - params_.inner_radius_m);
  return {share_of_sweep(p, params_.phi_max_rad), std::clamp(v, 0.0, 1.0)};
}

template <typename Real>
BandArea Disk<Real>::area_of(const Band& band) const {
  // The radius grows downwards, from the inner edge, and area with its square.
  const double inner = params_.inner_radius_m, ring = params_.radius_m - inner;
  const double middle = inner + ring * (band.above + band.height / 2);
  const double per_whole = band.height / ((params_.radius_m + inner) / 2);
  return {middle * per_whole, ring * band.height / 6 * per_whole};
}

template <typename Real>
SurfacePoint<Real> Disk<Real>::at_shares(Vec2<double> shares) const {
  const double inner = params_.inner_radius_m;
  const double r = std::sqrt(
      inner * inner + (1 - shares.y) * ((params_.radius_m - inner) * (params_.radius_m + inner)));
  const double phi = params_.phi_max_rad * shares.x;
  return surface_point(on_ring(r, phi, params_.height_m));
}

template class Disk<float>;
template class Disk<double>;

}  // namespace lucerna
