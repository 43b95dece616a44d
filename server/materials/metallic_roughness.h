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

struct MetallicRoughnessParams {
  Rgb base{1.0};        ///< the metal's reflectance at f0; the diffuse or transmitted share
  double metallic = 0;  ///< 0: a dielectric, 1: a metal
  Vec2 alpha{};         ///< roughness along x and y, as in Conductor
  double turn_rad = 0;  ///< from the surface's u to x, counter-clockwise
  /// What a dielectric's facets reflect along their normal, and at grazing angles.  f0 <= f90.
  Rgb f0{0.04};
  double f90 = 1;
  /// Share of the light beyond the facets that passes; the rest is diffuse.
  double transmission = 0;
  double coat = 0;  ///< share of the surface with a clear coat of index 1.5
  double coat_alpha = 0;
};

/// All numbers of the parameters are in [0, 1], except the turn.
class MetallicRoughness {
 public:
  /// `sides`: kBoth for a sheet: light that passes goes on in its direction, spread by the
  /// roughness. Without kTransmitted, `transmission` is not used.
  explicit MetallicRoughness(const MetallicRoughnessParams& params, Side sides = Side::kReflected);

  Side sides() const { return sides_; }
  bool all_delta() const { return smooth_ && diffuse_.is_black() && (coat_ == 0 || coat_smooth_); }
  Rgb single(const Vec3& wo, Side side) const;
  Rgb value(const Vec3& wo, const Vec3& wi) const { return evaluate(wo, wi).value; }
  SolidAnglePdf pdf(const Vec3& wo, const Vec3& wi) const { return {evaluate(wo, wi).pdf}; }
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const;

 private:
  enum class Lobe : std::uint8_t { kCoat, kReflected, kPassed, kDiffuse };
  /// Probabilities of the lobes.
  struct Shares {
    double coat{}, reflected{}, passed{}, diffuse{};
  };
  struct Evaluation {
    Rgb value{};
    double pdf{};
  };
  /// What facets send from one direction to another, without their Fresnel factor.
  struct Facets {
    double value{}, pdf{}, schlick{};
  };

  bool transmits() const { return has(sides_, Side::kTransmitted); }
  Vec3 turned(const Vec3& w) const;
  Vec3 turned_back(const Vec3& w) const;
  Shares shares(double cosine) const;
  Evaluation evaluate(const Vec3& wo, const Vec3& wi) const;
  bool is_single(Lobe lobe) const;
  /// The share of light that a lobe of one direction sends to `wo`.
  Rgb single(Lobe lobe, const Vec3& wo) const;
  static Facets facets_between(const Microfacets& facets, const Vec3& wo, const Vec3& wi);
  Rgb reflected(double schlick) const { return f0_ * (1 - schlick) + f90_ * schlick; }
  /// The share that a dielectric's facets leave, the least of the channels.
  double left(double schlick) const { return 1 - left_f0_ * (1 - schlick) - left_f90_ * schlick; }
  /// The share that all facets leave of light along `w`.
  double left_in_all(const Vec3& w) const;
  /// The share of light along a direction of this cosine that the coat leaves.
  double below_coat(double cosine) const;

  Side sides_;
  Rgb f0_, f90_;  // of metal and dielectric together
  Rgb diffuse_, passed_;
  double left_f0_, left_f90_;
  Microfacets facets_;
  double cos_turn_, sin_turn_;
  double coat_;
  Microfacets coat_facets_;
  bool smooth_, coat_smooth_;
};

}  // namespace lucerna
