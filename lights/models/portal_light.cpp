#include "lights/models/portal_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lights/maths/level_validation.h"
#include "lights/maths/stop_poll.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/models/irradiance.h"
#include "lights/pictures/rectified_map.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/projected_solid_angle.h"

namespace lucerna {
namespace {

/// Cells along a side of the table: about as many as the picture has rows.  A cell is the mean of a
/// few lookups.
int table_size(const SphereMap* map) {
  return map == nullptr ? 64 : std::clamp(map->image().height(), 64, 1024);
}

absl::Status check_corners(const std::array<Vec3, 4>& c, const Vec3& origin_m) {
  for (const Vec3& corner : c)
    if (auto s = check_position("infinite.portal", corner, origin_m); !s.ok()) return s;
  return absl::OkStatus();
}

}  // namespace

auto PortalLight::rectangle(const Params& params, const Vec3& origin_m)
    -> absl::StatusOr<Rectangle> {
  if (auto s = check_light_value("infinite.radiance", params.radiance_cd_m2, "cd/m2"); !s.ok())
    return s;
  if (params.map != nullptr)
    if (auto s = check_light_value("infinite.radiance of the brightest texel",
                                   params.map->brightest() * params.radiance_cd_m2, "cd/m2");
        !s.ok())
      return s;
  if (!params.rectified && !params.world_from_map.uniform_scale())
    return absl::InvalidArgumentError(
        "infinite.world_from_map has unequal scale, allowed: equal scale on all axes, or a "
        "resampled map");
  if (auto s = check_corners(params.corners_m, origin_m); !s.ok()) return s;

  std::array<Vec3, 4> c;
  for (std::size_t i = 0; i < 4; ++i) c[i] = params.corners_m[i] - origin_m;
  // Halved before they are added, so that no sum overflows.
  const Vec3 along_x = (c[3] * 0.5 - c[0] * 0.5) + (c[2] * 0.5 - c[1] * 0.5);
  const Vec3 along_y = (c[1] * 0.5 - c[0] * 0.5) + (c[2] * 0.5 - c[3] * 0.5);
  const Vec3 x = normalized(along_x);
  const Vec3 y = normalized(along_y - x * dot(along_y, x));
  const double width = length(along_x), height = dot(along_y, y);
  const Vec3 centre = (c[0] * 0.5 + c[2] * 0.5) * 0.5 + (c[1] * 0.5 + c[3] * 0.5) * 0.5;
  const Vec3 corner = centre - x * (width / 2) - y * (height / 2);
  const auto off = [&](std::size_t i, double u, double v) {
    return length(c[i] - (corner + x * (u * width) + y * (v * height)));
  };
  const double worst = std::max({off(0, 0, 0), off(1, 0, 1), off(2, 1, 1), off(3, 1, 0)});
  const double area = width * height;
  if (!(area > 0 && std::isfinite(area) && worst <= kRectangleTolerance * std::min(width, height)))
    return absl::InvalidArgumentError(fmt::format(
        "infinite.portal = ({}, {}, {}), ({}, {}, {}), ({}, {}, {}), ({}, {}, {}) m, allowed: four "
        "corners of a rectangle in order, to within {:g} of its shorter side",
        params.corners_m[0].x, params.corners_m[0].y, params.corners_m[0].z, params.corners_m[1].x,
        params.corners_m[1].y, params.corners_m[1].z, params.corners_m[2].x, params.corners_m[2].y,
        params.corners_m[2].z, params.corners_m[3].x, params.corners_m[3].y, params.corners_m[3].z,
        kRectangleTolerance));
  return Rectangle{corner, x, y, width, height};
}

absl::Status PortalLight::check(const Params& params, const Vec3& origin_m) {
  return rectangle(params, origin_m).status();
}

absl::StatusOr<PortalLight> PortalLight::create(const Params& params, const Vec3& origin_m) {
  const auto r = rectangle(params, origin_m);
  if (!r.ok()) return r.status();
  return PortalLight(params, *r);
}

PortalLight::PortalLight(const Params& params, const Rectangle& r)
    : LightBeyond(/*leaves_freely=*/true, /*has_irradiance=*/true),
      params_(params),
      map_axes_(params.world_from_map),
      corner_(r.corner),
      x_(r.x),
      y_(r.y),
      z_(cross(r.x, r.y)),
      width_(r.width),
      height_(r.height) {
  const SphereMap* map = params.map.get();
  const auto in_map = [&](const Vec3& v) { return map_axes_.map_from_world(v); };
  if (map == nullptr) {
    on_portal_ = {params.radiance_cd_m2 * kPi, 0, params.radiance_cd_m2 * (2 * kPi)};
  } else if (params.rectified) {
    if (params.world_from_map.uniform_scale()) {
      rectified_ = std::make_shared<const RectifiedMap>(*map, in_map(x_), in_map(y_), in_map(z_));
    } else {
      // Directions in the map's own space, as in pbrt-v4.
      const Transform own = params.world_from_map.inverse();
      rectified_ = std::make_shared<const RectifiedMap>(*map, own.vector(x_), own.vector(y_),
                                                        own.vector(z_));
    }
    on_portal_ = rectified_->illuminance(params.radiance_cd_m2);
  } else {
    on_portal_ = illuminance_of(*map, params.radiance_cd_m2, in_map(z_));
  }
  const int n = table_size(map);
  // One lookup for each row of the picture, so that no row is missed.  A picture that is much
  // higher than wide gets not many more lookups than texels.  Missed texels still have the uniform
  // share of the samples.
  const int rows = map == nullptr ? 1 : map->image().height();
  const int most =
      map == nullptr
          ? 1
          : std::max(2048,
                     static_cast<int>(std::sqrt(static_cast<double>(rows) * map->image().width())));
  const int looks = std::max(std::clamp(1024 / n, 1, 4), (std::min(rows, most) + n - 1) / n);
  std::vector<double> weights(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  StopPoll poll;
  for (int j = 0; j < n * looks; ++j)
    for (int i = 0; i < n * looks; ++i, poll()) {
      const Vec2 p{(i + 0.5) / (n * looks), (j + 0.5) / (n * looks)};
      const Vec3 w = rectified_from_square(p);
      weights[static_cast<std::size_t>(j / looks) * static_cast<std::size_t>(n) +
              static_cast<std::size_t>(i / looks)] += luminance(sky(w)) * sr_per_square(w);
    }
  table_ = std::make_shared<const WindowedDistribution>(n, weights);
}

NoLight PortalLight::window(const Vec3& position, Window& window) const {
  if (!is_finite(position)) return NoLight::kOutOfRange;
  const Vec3 p = local(position - corner_);
  const double depth = -p.z;
  if (depth == 0 && p.x >= 0 && p.x <= width_ && p.y >= 0 && p.y <= height_)
    return NoLight::kDegenerate;
  if (!(depth > 0)) return NoLight::kBehind;
  // The angle between two directions comes from their product.  The difference would cancel if the
  // portal is far.
  const auto begin = [&](double from) { return std::atan2(from, depth) / kPi + 0.5; };
  const auto extent = [&](double from, double side) {
    return std::atan2(side * depth, depth * depth + from * (from + side)) / kPi;
  };
  window = {begin(-p.x), begin(-p.y), extent(-p.x, width_), extent(-p.y, height_)};
  return window.width > 0 && window.height > 0 ? NoLight::kNone : NoLight::kOutOfRange;
}

Rgb PortalLight::sky(const Vec3& l) const {
  if (params_.map == nullptr) return Rgb(1);
  if (rectified_ != nullptr) return l.z > 0 ? rectified_->lookup(square_from_rectified(l)) : Rgb();
  return params_.map->lookup(map_axes_.map_from_world(x_ * l.x + y_ * l.y + z_ * l.z));
}

Rgb PortalLight::radiance(const Vec3& w) const {
  const Rgb value(sky(local(w)) * params_.radiance_cd_m2);
  if (!is_finite(value) || !(value.max_component() >= std::numeric_limits<double>::min()))
    return {};
  return value;
}

double PortalLight::density(const Window& window, const Vec3& w) const {
  const Vec3 l = normalized(local(w));
  if (!(l.z > 0)) return 0;
  const Vec2 p = square_from_rectified(l);
  // A direction and the window are rounded to `double`.  The nearer a direction is to an axis, the
  // more the rounding turns the angle about that axis.
  constexpr double kRounding = 2 * std::numeric_limits<double>::epsilon();
  const auto within = [&](double at, double begin, double extent, double from_axis) {
    const double slack = kRounding / from_axis;
    return at >= begin - slack && at <= begin + extent + slack;
  };
  if (!within(p.x, window.x, window.width, std::hypot(l.x, l.z)) ||
      !within(p.y, window.y, window.height, std::hypot(l.y, l.z)))
    return 0;
  const auto inside = [](double at, double begin, double extent) {
    return std::clamp(at, begin, begin + extent);
  };
  return table_->pdf(window,
                     {inside(p.x, window.x, window.width), inside(p.y, window.y, window.height)}) /
         sr_per_square(l);
}

NoLight PortalLight::sample(const Window& window, Vec2 u, Vec3& wi, Rgb& value,
                            SolidAnglePdf& pdf) const {
  const auto s = table_->sample(window, {double{u.x}, double{u.y}});
  // Stay away from the edges, so that the rounded direction leads through the portal.
  const auto within = [](double at, double begin, double extent) {
    const double slack = std::min(8 * std::numeric_limits<double>::epsilon(), extent * 0.5);
    return std::clamp(at, begin + slack, std::max(begin + slack, begin + extent - slack));
  };
  const Vec3 l = rectified_from_square({within(s.position.x, window.x, window.width),
                                        within(s.position.y, window.y, window.height)});
  wi = x_ * l.x + y_ * l.y + z_ * l.z;
  value = radiance(wi);
  if (value.is_black()) return NoLight::kBlack;
  pdf.per_sr = density(window, wi);
  if (pdf.per_sr >= std::numeric_limits<double>::min() && std::isfinite(pdf.per_sr))
    return NoLight::kNone;
  value = {};
  return NoLight::kOutOfRange;
}

LightSample PortalLight::sample_li(const Receiver& receiver, Vec2 u) const {
  LightSample s;
  s.pdf.per_sr = 1;
  Window seen;
  s.reason = window(receiver.position, seen);
  if (s.reason != NoLight::kNone) return s;
  s.distance = std::numeric_limits<double>::infinity();
  s.reason = sample(seen, u, s.wi, s.value, s.pdf);
  // The portal is narrower than the rounding of a direction.
  if (s.reason == NoLight::kNone && le_escaped(receiver.position, s.wi).is_black()) {
    s.value = {};
    s.reason = NoLight::kOutOfRange;
  }
  if (s.reason != NoLight::kNone) s.pdf.per_sr = 1;
  return s;
}

SolidAnglePdf PortalLight::pdf_li(const Receiver& receiver, const Vec3& wi) const {
  Window seen;
  if (!is_finite(wi) || window(receiver.position, seen) != NoLight::kNone) return {};
  if (radiance(wi).is_black()) return {};
  const double pdf = density(seen, wi);
  return {pdf >= std::numeric_limits<double>::min() && std::isfinite(pdf) ? pdf : 0};
}

std::optional<Rgb> PortalLight::irradiance(const Receiver& receiver) const {
  if (params_.map != nullptr) return std::nullopt;
  return uniform_irradiance(params_.radiance_cd_m2, receiver);
}

MostIrradiance PortalLight::most_irradiance(const Receiver& receiver) const {
  Window unused;
  if (window(receiver.position, unused) != NoLight::kNone) return {};
  const Vec3 p(receiver.position), n(receiver.normal);
  bool is_above = n == Vec3{};
  for (const Vec3& corner : corners_m()) is_above |= dot(corner - p, n) > 0;
  const double all = luminance(on_portal_.without_cosine);
  if (!is_above || !(all > 0)) return {};
  if (params_.map == nullptr) return {all, all / (1 - WindowedDistribution::kUniformShare)};
  // `all` counts cells that cross the portal's plane by half at least.  A cell of the table may
  // miss its brightest texel, so samples have no useful bound.
  return {2 * all, std::numeric_limits<double>::infinity()};
}

std::optional<Rgb> PortalLight::uniform_irradiance(const Rgb& radiance_cd_m2,
                                                   const Receiver& receiver) const {
  return irradiance_of(radiance_cd_m2, receiver, [&](const Vec3& normal) {
    const Vec3 p(receiver.position);
    const double depth = dot(corner_ - p, z_);
    return depth > 0 ? polygon_projected_solid_angle(corners_m(), p, normal, depth) : 0;
  });
}

Rgb PortalLight::le_escaped(const Vec3& origin, const Vec3& w) const {
  const Vec3 p = local(origin - corner_);
  const Vec3 l = local(w);
  if (!is_finite(l) || !(p.z < 0) || !(l.z > 0)) return {};
  // Compare the crossing with the plane times l.z, which avoids the division.
  const auto crosses = [&](double at, double slope, double side) {
    const double x = at * l.z - slope * p.z;
    return x >= 0 && x <= side * l.z;
  };
  if (!crosses(p.x, l.x, width_) || !crosses(p.y, l.y, height_)) return {};
  return radiance(w);
}

EmissionSample PortalLight::sample_le(Vec2 u_position, Vec2 u_direction, const SceneSphere&) const {
  EmissionSample s;
  Vec3 wi;
  Rgb value;
  s.reason = sample({}, u_direction, wi, value, s.pdf_direction);
  s.pdf_position.per_m2 = 1 / portal_area_m2();
  s.origin = corner_ + x_ * (double{u_position.x} * width_) + y_ * (double{u_position.y} * height_);
  s.direction = -wi;
  s.normal = -z_;
  if (s.reason == NoLight::kNone &&
      !(is_finite(s.origin) && s.pdf_position.per_m2 > 0 && std::isfinite(s.pdf_position.per_m2)))
    s.reason = NoLight::kOutOfRange;
  if (s.reason == NoLight::kNone)
    s.value = value;
  else
    s.pdf_position = {}, s.pdf_direction = {};
  return s;
}

EmissionPdf PortalLight::pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere&,
                                double slack_m) const {
  const Vec3 p = local(position - corner_);
  // Each coordinate of the position and of the portal is rounded once.
  const double slack =
      slack_m + 8 * kInputRounding * (max_abs(position) + max_abs(corner_) + width_ + height_);
  const auto within = [&](double at, double side) { return at >= -slack && at <= side + slack; };
  if (!within(p.x, width_) || !within(p.y, height_) || !(std::fabs(p.z) <= slack)) return {};
  if (!is_finite(direction) || radiance(-direction).is_black()) return {};
  const EmissionPdf pdf{{1 / portal_area_m2()}, {density({}, -direction)}};
  const auto usable = [](double d) { return d > 0 && std::isfinite(d); };
  if (!usable(pdf.position.per_m2) || !usable(pdf.direction.per_sr)) return {};
  return pdf;
}

Power PortalLight::power(const SceneSphere&) const {
  return {on_portal_.lx * portal_area_m2(), on_portal_.error_lx * portal_area_m2()};
}

Power PortalLight::power_approximate(const SceneSphere& scene) const {
  return approximate_power(on_portal_.without_cosine * portal_area_m2(), power(scene));
}

LightBytes PortalLight::own_bytes() const {
  const std::uint64_t tables = table_->bytes() + (rectified_ == nullptr ? 0 : rectified_->bytes());
  return {.object = sizeof *this, .data = tables, .tables = tables};
}

std::optional<LightParams> PortalLight::made_from() const { return params_; }

std::optional<double> PortalLight::cross_section_m2(const SceneSphere&) const {
  const auto corners = corners_m();
  return length(cross(corners[1] - corners[0], corners[3] - corners[0]));
}

LightPlace PortalLight::place(const Params& params) {
  Bounds box;
  for (const Vec3& corner : params.corners_m) box.add(corner);
  return {.anchor_m = params.corners_m[0], .portal_m = box};
}

}  // namespace lucerna
