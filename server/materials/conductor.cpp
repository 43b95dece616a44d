#include "server/materials/conductor.h"

#include "server/materials/fresnel.h"

namespace lucerna {
namespace {

/// The facet normal that mirrors `wi` to `wo`, on the side of +z.  Zero if there is none.
template <std::floating_point Real>
Vec3<Real> half_way(const Vec3<Real>& wo, const Vec3<Real>& wi) {
  if (!same_side(wo, wi)) return {};
  const Vec3<Real> m = normalized(wo + wi);
  return m.z < 0 ? -m : m;
}

}  // namespace

template <std::floating_point Real>
Rgb<Real> Conductor<Real>::reflected(Real cosine) const {
  return fresnel_conductor(std::fabs(cosine), eta_, k_);
}

template <std::floating_point Real>
Rgb<Real> Conductor<Real>::value(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
  const SolidAnglePdf<Real> density = pdf(wo, wi);
  if (!(density.per_sr > 0)) return {};
  return reflected(dot(wo, half_way(wo, wi))) * (facets_.also_seen(wo, wi) * density.per_sr);
}

template <std::floating_point Real>
SolidAnglePdf<Real> Conductor<Real>::pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
  if (smooth_) return {};
  const Vec3<Real> m = half_way(wo, wi);
  if (!(m.z > 0)) return {};
  // The reflection stretches solid angles by 4 cos, and the density of visible normals has a cos.
  return {facets_.seen_per_cosine(wo) * facets_.density(m) / 4};
}

template <std::floating_point Real>
std::optional<ScatterSample<Real>> Conductor<Real>::sample(const Vec3<Real>& wo,
                                                           const ScatterValues<Real>& u) const {
  if (wo.z == 0) return std::nullopt;
  if (smooth_)
    return ScatterSample<Real>{.wi = mirrored(wo), .weight = reflected(wo.z), .delta = true};
  const Vec3<Real> up = wo.z < 0 ? -wo : wo;
  const Vec3<Real> m = facets_.sample(up, u.direction);
  Vec3<Real> wi = m * (2 * dot(up, m)) - up;
  if (!(wi.z > 0)) return std::nullopt;  // hits another facet, which is not modelled
  if (wo.z < 0) wi = -wi;
  const SolidAnglePdf<Real> density = pdf(wo, wi);
  if (!(density.per_sr > 0)) return std::nullopt;
  return ScatterSample<Real>{
      .wi = wi, .weight = reflected(dot(up, m)) * facets_.also_seen(wo, wi), .pdf = density};
}

template class Conductor<float>;
template class Conductor<double>;

}  // namespace lucerna
