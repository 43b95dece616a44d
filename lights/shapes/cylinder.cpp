#include "lights/shapes/cylinder.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace lucerna {

namespace {

absl::Status check(const CylinderParams& p) {
  if (auto s = check_radius("cylinder", p); !s.ok()) return s;
  if (!std::isfinite(p.z_min_m)) return refuse_field("cylinder", "z_min_m", p.z_min_m, "finite");
  if (!(p.z_max_m > p.z_min_m) || !std::isfinite(p.z_max_m))
    return refuse_field("cylinder", "z_max_m", p.z_max_m,
                        fmt::format("finite, more than z_min_m, {}", p.z_min_m));
  return check_sweep("cylinder", p);
}

Vec3 column(const Transform& t, int j) {
  const auto& m = t.matrix();
  return {m[0][j], m[1][j], m[2][j]};
}

/// The factors across and along the axis, if the map keeps the cylinder circular and upright to
/// within 1e-6, as in Transform::uniform_scale.  Nothing otherwise.
std::optional<Vec2> scale_of(const Transform& t) {
  constexpr double kTolerance = 1e-6;
  const Vec3 x = column(t, 0), y = column(t, 1), z = column(t, 2);
  const auto sheared = [](const Vec3& a, const Vec3& b) {
    return std::fabs(dot(normalized(a), normalized(b))) > kTolerance;
  };
  if (sheared(x, y) || sheared(y, z) || sheared(z, x)) return std::nullopt;
  if (std::fabs(length(x) - length(y)) > kTolerance * length(x)) return std::nullopt;
  return Vec2{length(x), length(z)};
}

}  // namespace

Cylinder::Cylinder(const CylinderParams& params, const Vec3& origin_m) : Base(params, origin_m) {
  if (const auto scale = scale_of(params.world_from_object))
    area_m2_ = params.phi_max_rad * (params.radius_m * scale->x) *
               ((params.z_max_m - params.z_min_m) * scale->y);
}

absl::StatusOr<Cylinder> Cylinder::create(const CylinderParams& params, const Vec3& origin_m) {
  if (absl::Status status = check(params); !status.ok()) return status;
  return Base::with_finite_bounds(Cylinder(params, origin_m), "cylinder", "the cylinder's base",
                                  {0, 0, params.z_min_m});
}

absl::Status Cylinder::emissive_error() const {
  if (scale_of(params_.world_from_object)) return absl::OkStatus();
  return this->refuse_map("cylinder", "equal factors for x and y, no shear");
}

ShapeSample Cylinder::sample(const Receiver& receiver, Vec2 u) const {
  const double z = std::lerp(params_.z_min_m, params_.z_max_m, static_cast<double>(u.x));
  const double phi = params_.phi_max_rad * u.y;
  ShapeSample s;
  s.point = surface_point(on_ring(params_.radius_m, phi, z));
  s.pdf = pdf(receiver, s.point);
  return s;
}

SolidAnglePdf Cylinder::pdf(const Receiver& receiver, const SurfacePoint& point) const {
  return pdf_by_area(receiver, point);
}

bool Cylinder::is_cut_away(const Vec3& p) const {
  // Written with a negation, so that NaN counts as cut away.
  if (!(p.z >= params_.z_min_m && p.z <= params_.z_max_m)) return true;
  return !is_swept(p, params_.phi_max_rad);
}

int Cylinder::roots(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
                    QuadricRoots& out) const {
  const double r = params_.radius_m;
  const Vec3 o = object_from_world_.point(origin);
  const Vec3 d = object_from_world_.vector(direction);
  const double dd = d.x * d.x + d.y * d.y;
  if (!(dd > 0)) return 0;
  // Across the axis, as for the sphere: start from the point of closest approach.  b^2 - 4 a c
  // would cancel for far origins and thin tubes.  [Haines19]
  const double closest = -(o.x * d.x + o.y * d.y) / dd;
  const Vec2 approach{o.x + d.x * closest, o.y + d.y * closest};
  const double approach_distance = std::hypot(approach.x, approach.y);
  if (!(approach_distance <= r)) return 0;
  const double half_chord = std::sqrt((r - approach_distance) * (r + approach_distance) / dd);
  const auto [first, second] = Base::roots_of(closest, half_chord, std::hypot(o.x, o.y), r, dd);

  int count = 0;
  const auto add = [&](double t, double chord) {
    if (!(t > t_min && t < t_max)) return;
    const double x = approach.x + d.x * chord, y = approach.y + d.y * chord;
    const double to_surface = r / std::hypot(x, y);
    const Vec3 p{x * to_surface, y * to_surface, o.z + d.z * t};
    if (!is_cut_away(p)) out[count++] = {t, p};
  };
  add(first, -half_chord);
  add(second, half_chord);
  return count;
}

std::pair<Vec3, Vec3> Cylinder::bounds() const {
  const auto& m = world_from_object_.matrix();
  const Vec3 bottom = world_from_object_.point({0, 0, params_.z_min_m});
  const Vec3 top = world_from_object_.point({0, 0, params_.z_max_m});
  // The extent of each end's ellipse along an axis is the length of that row of the map.
  const auto extent = [&](int row) { return params_.radius_m * std::hypot(m[row][0], m[row][1]); };
  const Vec3 half{extent(0), extent(1), extent(2)};
  const auto lower = [](double a, double b) { return std::min(a, b); };
  const auto upper = [](double a, double b) { return std::max(a, b); };
  return rounded_outwards(
      Vec3{lower(bottom.x, top.x), lower(bottom.y, top.y), lower(bottom.z, top.z)} - half,
      Vec3{upper(bottom.x, top.x), upper(bottom.y, top.y), upper(bottom.z, top.z)} + half);
}

std::optional<Vec3> Cylinder::nearest(const Vec3& p) const {
  const double to_surface = params_.radius_m / std::hypot(p.x, p.y);
  const Vec3 q{p.x * to_surface, p.y * to_surface,
               std::clamp(p.z, params_.z_min_m, params_.z_max_m)};
  if (!is_finite(q)) return std::nullopt;
  return q;
}

NormalCone Cylinder::normals() const {
  if (!(params_.phi_max_rad < kTurnRad)) return {};
  const double middle = params_.phi_max_rad / 2;
  const Vec3 axis = world_from_object_.normal({std::cos(middle), std::sin(middle), 0});
  return {normalized(params_.reverse_orientation ? -axis : axis),
          std::min(middle + kNormalSlackRad, std::numbers::pi)};
}

Vec2 Cylinder::uv(const SurfacePoint& point) const {
  const Vec3 p = object_from_world_.point(point.position);
  const double v = (p.z - params_.z_min_m) / (params_.z_max_m - params_.z_min_m);
  return {share_of_sweep(p, params_.phi_max_rad), std::clamp(v, 0.0, 1.0)};
}

BandArea Cylinder::area_of(const Band& band) const { return {band.height, 0}; }

SurfacePoint Cylinder::at_shares(Vec2 shares) const {
  const double phi = params_.phi_max_rad * shares.x;
  return surface_point(
      on_ring(params_.radius_m, phi, std::lerp(params_.z_min_m, params_.z_max_m, shares.y)));
}

bool Cylinder::touches(const Vec3& position, std::uint32_t) const {
  const Vec3 p = object_from_world_.vector(position - world_from_object_.point({0, 0, 0}));
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  return std::fabs(std::hypot(p.x, p.y) - params_.radius_m) <= kRounding * params_.radius_m &&
         !is_cut_away(p);
}

}  // namespace lucerna
