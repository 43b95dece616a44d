// Metals: mirrors, and rough ones.
#pragma once

#include "server/materials/microfacet.h"
#include "server/materials/scattering.h"

namespace lucerna {

/// Reflects by Fresnel's equations at smooth or microfaceted surfaces.  [Pharr23, 9.3.6, 9.6]
class Conductor {
 public:
  static constexpr Side sides() { return Side::kReflected; }
  /// `eta`, `k`: the complex index relative to the outside, at least 0.  `alpha_x`, `alpha_y`:
  /// roughness, at least 0; smooth if both are below Microfacets::kSmooth.
  Conductor(const Rgb& eta, const Rgb& k, double alpha_x, double alpha_y)
      : eta_(eta),
        k_(k),
        facets_(Microfacets::rough(alpha_x), Microfacets::rough(alpha_y)),
        smooth_(Microfacets::is_smooth(alpha_x, alpha_y)) {}

  bool all_delta() const { return smooth_; }
  Rgb single(const Vec3& wo, Side side) const {
    return smooth_ && side == Side::kReflected ? reflected(wo.z) : Rgb();
  }
  Vec2 alpha() const { return facets_.alpha(); }
  Rgb value(const Vec3& wo, const Vec3& wi) const;
  SolidAnglePdf pdf(const Vec3& wo, const Vec3& wi) const;
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const;
  /// The share of light that a facet reflects at an angle of this cosine.
  Rgb reflected(double cosine) const;

 private:
  Rgb eta_, k_;
  Microfacets facets_;
  bool smooth_;
};

}  // namespace lucerna
