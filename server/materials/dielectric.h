// Glass, water and the like: boundaries that reflect and refract, and thin panes.
#pragma once

#include "server/materials/microfacet.h"
#include "server/materials/scattering.h"

namespace lucerna {

/// A boundary between two dielectrics, smooth or microfaceted.  [Walter07], [Pharr23, 9.5, 9.7]
template <std::floating_point Real>
class Dielectric {
 public:
  static constexpr Side kSides = Side::kBoth;
  /// `eta`: the index on the side to which -z points, over that to which +z points; above 0.
  /// Roughness as in Conductor.  A boundary of equal indices is smooth.
  Dielectric(Real eta, Real alpha_x, Real alpha_y)
      : eta_(eta),
        facets_(Microfacets<Real>::rough(alpha_x), Microfacets<Real>::rough(alpha_y)),
        smooth_(eta == 1 || Microfacets<Real>::is_smooth(alpha_x, alpha_y)) {}

  Real eta() const { return eta_; }
  bool all_delta() const { return smooth_; }
  Rgb<Real> single(const Vec3<Real>& wo, Side side) const;
  Vec2<Real> alpha() const { return facets_.alpha(); }
  Rgb<Real> value(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
    return Rgb<Real>(value(wo, wi, Carries::kRadiance));
  }
  SolidAnglePdf<Real> pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
    return {pdf(wo, wi, Side::kBoth)};
  }
  std::optional<ScatterSample<Real>> sample(const Vec3<Real>& wo,
                                            const ScatterValues<Real>& u) const;

  /// The same for one side only, and for the quantity that a path carries.  Layers need them.
  Real value(const Vec3<Real>& wo, const Vec3<Real>& wi, Carries carries) const;
  Real pdf(const Vec3<Real>& wo, const Vec3<Real>& wi, Side sides) const;
  struct Sample {
    Vec3<Real> wi;
    Real weight = 0;  ///< as in ScatterSample
    Real pdf = 0;
    bool delta = false;
  };
  std::optional<Sample> sample(const Vec3<Real>& wo, const ScatterValues<Real>& u, Side sides,
                               Carries carries) const;

 private:
  Real eta_;
  Microfacets<Real> facets_;
  bool smooth_;
};

/// A pane so thin that light leaves it where it entered, in its direction.  Includes the
/// reflections between its two sides.  [Pharr23, 9.5.2]
template <std::floating_point Real>
class ThinDielectric {
 public:
  static constexpr Side kSides = Side::kBoth;
  explicit ThinDielectric(Real eta) : eta_(eta) {}

  bool all_delta() const { return true; }
  Rgb<Real> single(const Vec3<Real>& wo, Side side) const {
    return Rgb<Real>(side == Side::kTransmitted ? passed(wo.z) : 1 - passed(wo.z));
  }
  Rgb<Real> value(const Vec3<Real>&, const Vec3<Real>&) const { return {}; }
  SolidAnglePdf<Real> pdf(const Vec3<Real>&, const Vec3<Real>&) const { return {}; }
  std::optional<ScatterSample<Real>> sample(const Vec3<Real>& wo,
                                            const ScatterValues<Real>& u) const;
  /// The share of light that passes straight on; the rest is reflected.
  Real passed(Real cosine) const;

 private:
  Real eta_;
};

}  // namespace lucerna
