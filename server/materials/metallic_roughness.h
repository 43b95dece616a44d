// The surface of glTF files: something between a metal and a dielectric, with a base colour and a
// roughness.  [glTF2, appendix B]
//
// A metal reflects at its facets.  A dielectric reflects at its facets too, and scatters the rest
// evenly or lets it through.  A clear coat may lie above.  Fresnel's equations are replaced by
// Schlick's formula.  [Schlick94]
//
// The specification adds the light of facets and the diffuse light without regard to their sum,
// which is almost 2 at grazing angles.  Here the diffuse part is what the facets leave, by the
// albedo of facets towards both directions.  So no surface reflects more than it receives, and
// along the normal of a smooth surface the sum is that of the specification.
#pragma once

#include "server/materials/facet_albedo.h"
#include "server/materials/microfacet.h"
#include "server/materials/scattering.h"

namespace lucerna {

template <std::floating_point Real>
struct MetallicRoughnessParams {
  Rgb<Real> base{Real(1)};  ///< the metal's reflectance at f0; the diffuse or transmitted share
  Real metallic = 0;        ///< 0: a dielectric, 1: a metal
  Vec2<Real> alpha{};       ///< roughness along x and y, as in Conductor
  Real turn_rad = 0;        ///< from the surface's u to x, counter-clockwise
  /// What a dielectric's facets reflect along their normal, and at grazing angles.  f0 <= f90.
  Rgb<Real> f0{Real(0.04)};
  Real f90 = 1;
  Real transmission = 0;  ///< share of the light beyond the facets that passes; the rest is diffuse
  Real coat = 0;          ///< share of the surface with a clear coat of index 1.5
  Real coat_alpha = 0;
};

/// All numbers of the parameters are in [0, 1], except the turn.  Without kTransmitted in `kSide`,
/// `transmission` is not used.
template <std::floating_point Real, Side kSide>
class MetallicRoughnessOn {
 public:
  static constexpr Side kSides = kSide;
  explicit MetallicRoughnessOn(const MetallicRoughnessParams<Real>& params);

  bool all_delta() const { return smooth_ && diffuse_.is_black() && (coat_ == 0 || coat_smooth_); }
  Rgb<Real> single(const Vec3<Real>& wo, Side side) const;
  Rgb<Real> value(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
    return evaluate(wo, wi).value;
  }
  SolidAnglePdf<Real> pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const {
    return {evaluate(wo, wi).pdf};
  }
  std::optional<ScatterSample<Real>> sample(const Vec3<Real>& wo,
                                            const ScatterValues<Real>& u) const;

 private:
  static constexpr bool kTransmits = has(kSide, Side::kTransmitted);

  enum class Lobe : std::uint8_t { kCoat, kReflected, kPassed, kDiffuse };
  /// Probabilities of the lobes.
  struct Shares {
    Real coat{}, reflected{}, passed{}, diffuse{};
  };
  struct Evaluation {
    Rgb<Real> value{};
    Real pdf{};
  };
  /// What facets send from one direction to another, without their Fresnel factor.
  struct Facets {
    Real value{}, pdf{}, schlick{};
  };

  Vec3<Real> turned(const Vec3<Real>& w) const;
  Vec3<Real> turned_back(const Vec3<Real>& w) const;
  Shares shares(Real cosine) const;
  Evaluation evaluate(const Vec3<Real>& wo, const Vec3<Real>& wi) const;
  bool is_single(Lobe lobe) const;
  /// The share of light that a lobe of one direction sends to `wo`.
  Rgb<Real> single(Lobe lobe, const Vec3<Real>& wo) const;
  static Facets facets_between(const Microfacets<Real>& facets, const Vec3<Real>& wo,
                               const Vec3<Real>& wi);
  Rgb<Real> reflected(Real schlick) const { return f0_ * (1 - schlick) + f90_ * schlick; }
  /// The share that a dielectric's facets leave, the least of the channels.
  Real left(Real schlick) const { return 1 - left_f0_ * (1 - schlick) - left_f90_ * schlick; }
  /// The share that all facets leave of light along `w`.
  Real left_in_all(const Vec3<Real>& w) const;
  /// The share of light along a direction of this cosine that the coat leaves.
  Real below_coat(Real cosine) const;

  Rgb<Real> f0_, f90_;  // of metal and dielectric together
  Rgb<Real> diffuse_, passed_;
  Real left_f0_, left_f90_;
  Microfacets<Real> facets_;
  Real cos_turn_, sin_turn_;
  Real coat_;
  Microfacets<Real> coat_facets_;
  bool smooth_, coat_smooth_;
};

template <std::floating_point Real>
using MetallicRoughness = MetallicRoughnessOn<Real, Side::kReflected>;
/// A sheet: light that passes goes on in its direction, spread by the roughness.
template <std::floating_point Real>
using ThinMetallicRoughness = MetallicRoughnessOn<Real, Side::kBoth>;

}  // namespace lucerna
