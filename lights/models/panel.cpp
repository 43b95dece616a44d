#include "lights/models/panel.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace lucerna {

template <typename Surface>
absl::StatusOr<Panel<Surface>> Panel<Surface>::create(Surface surface, PanelProfile profile) {
  // A thousandth turns the photometry by less than the precision of its own angles.
  constexpr double kFlat = 1e-3;
  const NormalCone normals = surface.normals();
  if (!(normals.half_angle_rad <= kFlat))
    return absl::InvalidArgumentError(
        fmt::format("panel.surface has normals up to {:.3g} rad from their mean, allowed for a "
                    "profile: flat, up to {} rad",
                    normals.half_angle_rad, kFlat));
  const Vec3 n = normalized(normals.axis);
  const Vec3& t = profile.tangent;
  const Vec3 along = normalized(t);
  const Vec3 s = along - n * dot(along, n);
  if (!is_finite(t) || !(length(s) > kFlat))
    return absl::InvalidArgumentError(fmt::format(
        "panel.tangent = ({}, {}, {}), allowed: finite, not along the normal ({}, {}, {})", t.x,
        t.y, t.z, n.x, n.y, n.z));
  Frame axes;
  axes.n = n;
  axes.s = normalized(s);
  axes.t = profile.mirrored ? cross(axes.s, n) : cross(n, axes.s);
  return Panel(Data{std::move(surface), std::move(profile), axes});
}

template <typename Surface>
double Panel<Surface>::radiance(const Vec3& w, const Vec3& normal) const {
  const double cd = data_->profile.web->at(data_->axes.local_from_world(w));
  // Uses the point's own cosine.  The cosine of the mean plane is 0 at slightly different
  // directions.
  return cd > 0 ? cd / std::fabs(dot(w, normal)) / this->area() : 0;
}

template <typename Surface>
Vec3 Panel<Surface>::sample_direction(Vec2 u) const {
  return data_->axes.world_from_local(data_->profile.web->sample(u));
}

template <typename Surface>
SolidAnglePdf Panel<Surface>::pdf_direction(const Vec3& w) const {
  return data_->profile.web->pdf(data_->axes.local_from_world(w));
}

template <typename Surface>
double Panel<Surface>::flux_lm(bool two_sided) const {
  const PhotometricWeb& web = *data_->profile.web;
  return two_sided ? web.flux_lm() : web.downward_flux_lm();
}

template <typename Surface>
double Panel<Surface>::flux_error_lm(bool two_sided) const {
  // A flat shape's normals are a few roundings of its vertices apart, and so is their mean.
  constexpr double kRounding = 16 * kInputRounding;
  const double lean = data_->surface.normals().half_angle_rad;
  // On one side, a point's own hemisphere lacks the directions between its plane and the mean
  // plane.  On the other side it has as many more.
  return two_sided || lean <= kRounding ? 0 : data_->profile.web->horizon_flux_bound_lm(lean);
}

template <typename Surface>
NormalCone Panel<Surface>::directions(bool two_sided) const {
  const EmissionCone& cone = data_->profile.web->cone();
  const NormalCone whole{data_->axes.world_from_local(cone.axis), cone.half_angle_rad};
  // Each normal has its own hemisphere.
  const double hemisphere = std::numbers::pi / 2 + data_->surface.normals().half_angle_rad;
  if (two_sided || whole.half_angle_rad <= hemisphere) return whole;
  return {data_->axes.n, hemisphere};
}

#define LUCERNA_PANEL(Shape) template class Panel<Shape>;
LUCERNA_FLAT_SHAPES(LUCERNA_PANEL)
#undef LUCERNA_PANEL

}  // namespace lucerna
