#include "lights/models/panel.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace lucerna {

template <typename Real, template <typename> typename Surface>
absl::StatusOr<Panel<Real, Surface>> Panel<Real, Surface>::create(Surface<Real> surface,
                                                                  PanelProfile profile) {
  // A thousandth turns the photometry by less than the precision of its own angles.
  constexpr double kFlat = 1e-3;
  const NormalCone<Real> normals = surface.normals();
  if (!(normals.half_angle_rad <= kFlat))
    return absl::InvalidArgumentError(
        fmt::format("panel.surface has normals up to {:.3g} rad from their mean, allowed for a "
                    "profile: flat, up to {} rad",
                    normals.half_angle_rad, kFlat));
  const Vec3<double> n = normalized(Vec3<double>(normals.axis));
  const Vec3<double>& t = profile.tangent;
  const Vec3<double> along = normalized(t);
  const Vec3<double> s = along - n * dot(along, n);
  if (!is_finite(t) || !(length(s) > kFlat))
    return absl::InvalidArgumentError(fmt::format(
        "panel.tangent = ({}, {}, {}), allowed: finite, not along the normal ({}, {}, {})", t.x,
        t.y, t.z, n.x, n.y, n.z));
  Frame<double> axes;
  axes.n = n;
  axes.s = normalized(s);
  axes.t = profile.mirrored ? cross(axes.s, n) : cross(n, axes.s);
  return Panel(Data{std::move(surface), std::move(profile), axes});
}

template <typename Real, template <typename> typename Surface>
double Panel<Real, Surface>::radiance(const Vec3<double>& w, const Vec3<double>& normal) const {
  const double cd = data_->profile.web->at(data_->axes.local_from_world(w));
  // Uses the point's own cosine.  The cosine of the mean plane is 0 at slightly different
  // directions.
  return cd > 0 ? cd / std::fabs(dot(w, normal)) / this->area() : 0;
}

template <typename Real, template <typename> typename Surface>
Vec3<double> Panel<Real, Surface>::sample_direction(Vec2<double> u) const {
  return data_->axes.world_from_local(data_->profile.web->sample(u));
}

template <typename Real, template <typename> typename Surface>
SolidAnglePdf<double> Panel<Real, Surface>::pdf_direction(const Vec3<double>& w) const {
  return data_->profile.web->pdf(data_->axes.local_from_world(w));
}

template <typename Real, template <typename> typename Surface>
double Panel<Real, Surface>::flux_lm(bool two_sided) const {
  const PhotometricWeb& web = *data_->profile.web;
  return two_sided ? web.flux_lm() : web.downward_flux_lm();
}

template <typename Real, template <typename> typename Surface>
double Panel<Real, Surface>::flux_error_lm(bool two_sided) const {
  // A flat shape's normals are a few roundings of its vertices apart, and so is their mean.
  constexpr double kRounding = 16 * kInputRounding;
  const double lean = data_->surface.normals().half_angle_rad;
  // On one side, a point's own hemisphere lacks the directions between its plane and the mean
  // plane.  On the other side it has as many more.
  return two_sided || lean <= kRounding ? 0 : data_->profile.web->horizon_flux_bound_lm(lean);
}

template <typename Real, template <typename> typename Surface>
NormalCone<Real> Panel<Real, Surface>::directions(bool two_sided) const {
  const EmissionCone& cone = data_->profile.web->cone();
  const NormalCone<Real> whole{Vec3<Real>(data_->axes.world_from_local(cone.axis)),
                               cone.half_angle_rad};
  // Each normal has its own hemisphere.
  const double hemisphere = std::numbers::pi / 2 + data_->surface.normals().half_angle_rad;
  if (two_sided || whole.half_angle_rad <= hemisphere) return whole;
  return {Vec3<Real>(data_->axes.n), hemisphere};
}

#define LUCERNA_PANEL(Shape)          \
  template class Panel<float, Shape>; \
  template class Panel<double, Shape>;
LUCERNA_FLAT_SHAPES(LUCERNA_PANEL)
#undef LUCERNA_PANEL

}  // namespace lucerna
