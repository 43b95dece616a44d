// Metals: mirrors, and rough ones.
#pragma once

#include "server/materials/microfacet.h"
#include "server/materials/scattering.h"

namespace lucerna {

/// Reflects by Fresnel's equations at smooth or microfaceted surfaces.  [Pharr23, 9.3.6, 9.6]
template <std::floating_point Real>
class Conductor {
 public:
  static constexpr Side kSides = Side::kReflected;
  /// `eta`, `k`: the complex index relative to the outside, at least 0.  `alpha_x`, `alpha_y`:
  /// roughness, at least 0; smooth if both are below Microfacets::kSmooth.
  Conductor(const Rgb<Real>& eta, const Rgb<Real>& k, Real alpha_x, Real alpha_y)
      : eta_(eta),
        k_(k),
        facets_(Microfacets<Real>::rough(alpha_x), Microfacets<Real>::rough(alpha_y)),
        smooth_(Microfacets<Real>::is_smooth(alpha_x, alpha_y)) {}

  bool all_delta() const { return smooth_; }
  Rgb<Real> single(const Vec3<Real>& wo, Side side) const {
    return smooth_ && side == Side::kReflected ? reflected(wo.z) : Rgb<Real>();
  }
  Vec2<Real> alpha() const { return facets_.alpha(); }
  Rgb<Real> value(const Vec3<Real>& wo, const Vec3<Real>& wi) const;
  SolidAnglePdf<Real> pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const;
  std::optional<ScatterSample<Real>> sample(const Vec3<Real>& wo,
                                            const ScatterValues<Real>& u) const;
  /// The share of light that a facet reflects at an angle of this cosine.
  Rgb<Real> reflected(Real cosine) const;

 private:
  Rgb<Real> eta_, k_;
  Microfacets<Real> facets_;
  bool smooth_;
};

}  // namespace lucerna
