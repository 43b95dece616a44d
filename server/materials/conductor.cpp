#include "server/materials/conductor.h"

#include "server/materials/fresnel.h"

namespace lucerna {
namespace {

/// The facet normal that mirrors `wi` to `wo`, on the side of +z.  Zero if there is none.
Vec3 half_way(const Vec3& wo, const Vec3& wi) {
  if (!same_side(wo, wi)) return {};
  const Vec3 m = normalized(wo + wi);
  return m.z < 0 ? -m : m;
}

}  // namespace

Rgb Conductor::reflected(double cosine) const {
  return fresnel_conductor(std::fabs(cosine), eta_, k_);
}

Rgb Conductor::value(const Vec3& wo, const Vec3& wi) const {
  const SolidAnglePdf density = pdf(wo, wi);
  if (!(density.per_sr > 0)) return {};
  return reflected(dot(wo, half_way(wo, wi))) * (facets_.also_seen(wo, wi) * density.per_sr);
}

SolidAnglePdf Conductor::pdf(const Vec3& wo, const Vec3& wi) const {
  if (smooth_) return {};
  const Vec3 m = half_way(wo, wi);
  if (!(m.z > 0)) return {};
  // The reflection stretches solid angles by 4 cos, and the density of visible normals has a cos.
  return {facets_.seen_per_cosine(wo) * facets_.density(m) / 4};
}

std::optional<ScatterSample> Conductor::sample(const Vec3& wo, const ScatterValues& u) const {
  if (wo.z == 0) return std::nullopt;
  if (smooth_) return ScatterSample{.wi = mirrored(wo), .weight = reflected(wo.z), .delta = true};
  const Vec3 up = wo.z < 0 ? -wo : wo;
  const Vec3 m = facets_.sample(up, u.direction);
  Vec3 wi = m * (2 * dot(up, m)) - up;
  if (!(wi.z > 0)) return std::nullopt;  // hits another facet, which is not modelled
  if (wo.z < 0) wi = -wi;
  const SolidAnglePdf density = pdf(wo, wi);
  if (!(density.per_sr > 0)) return std::nullopt;
  return ScatterSample{
      .wi = wi, .weight = reflected(dot(up, m)) * facets_.also_seen(wo, wi), .pdf = density};
}

}  // namespace lucerna
