// Surfaces that scatter light evenly: on the side of the light, and through thin sheets such as
// leaves and paper.
#pragma once

#include <cmath>
#include <numbers>

#include "lights/sampling/sampling.h"
#include "server/materials/scattering.h"

namespace lucerna {

/// A direction about +z with density cos / pi.  z > 0.
inline Vec3 sample_cosine_hemisphere(Vec2 u) {
  const Vec2 d = sample_concentric_disk(u);
  // Directions within the surface have density 0.
  const double z = std::sqrt(std::fmax(0.0, 1 - d.x * d.x - d.y * d.y));
  return {d.x, d.y, std::fmax(z, 0x1p-24)};
}

/// Radiance is the same in all directions of a side.  `reflectance` and `transmittance` are shares
/// of the arriving light, at least 0, at most 1 together.
class DiffuseTransmission {
 public:
  static constexpr Side sides() { return Side::kBoth; }
  DiffuseTransmission(const Rgb& reflectance, const Rgb& transmittance)
      : reflectance_(reflectance), transmittance_(transmittance) {
    const double r = reflectance.max_component(), t = transmittance.max_component();
    reflected_ = r + t > 0 ? r / (r + t) : 0.0;
  }

  bool all_delta() const { return false; }
  Rgb single(const Vec3&, Side) const { return {}; }
  Rgb value(const Vec3& wo, const Vec3& wi) const {
    if (wo.z * wi.z == 0) return {};
    return (same_side(wo, wi) ? reflectance_ : transmittance_) *
           (std::fabs(wi.z) * std::numbers::inv_pi);
  }
  SolidAnglePdf pdf(const Vec3& wo, const Vec3& wi) const {
    if (wo.z * wi.z == 0) return {};
    const double share = same_side(wo, wi) ? reflected_ : 1 - reflected_;
    if ((reflectance_ + transmittance_).is_black()) return {};
    return {share * std::fabs(wi.z) * std::numbers::inv_pi};
  }
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const {
    if (wo.z == 0 || (reflectance_ + transmittance_).is_black()) return std::nullopt;
    const bool reflects = u.choice < reflected_;
    Vec3 wi = sample_cosine_hemisphere(u.direction);
    if ((wo.z < 0) == reflects) wi.z = -wi.z;
    const double share = reflects ? reflected_ : 1 - reflected_;
    return ScatterSample{
        .wi = wi, .weight = (reflects ? reflectance_ : transmittance_) / share, .pdf = pdf(wo, wi)};
  }

 private:
  Rgb reflectance_, transmittance_;
  double reflected_;  ///< probability of this side
};

/// Lambert's law: light returns to its side.
class Diffuse {
 public:
  static constexpr Side sides() { return Side::kReflected; }
  explicit Diffuse(const Rgb& reflectance) : reflectance_(reflectance) {}

  const Rgb& reflectance() const { return reflectance_; }
  bool all_delta() const { return false; }
  Rgb single(const Vec3&, Side) const { return {}; }
  Rgb value(const Vec3& wo, const Vec3& wi) const { return reflectance_ * pdf(wo, wi).per_sr; }
  SolidAnglePdf pdf(const Vec3& wo, const Vec3& wi) const {
    if (!same_side(wo, wi)) return {};
    return {std::fabs(wi.z) * std::numbers::inv_pi};
  }
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const {
    if (wo.z == 0 || reflectance_.is_black()) return std::nullopt;
    Vec3 wi = sample_cosine_hemisphere(u.direction);
    if (wo.z < 0) wi.z = -wi.z;
    return ScatterSample{.wi = wi, .weight = reflectance_, .pdf = pdf(wo, wi)};
  }

 private:
  Rgb reflectance_;
};

}  // namespace lucerna
