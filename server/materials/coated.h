// Surfaces under a clear coat: painted and varnished ones, and lacquered metals.
//
// Light passes the coat's boundary, is scattered by the base, and may be reflected within the coat
// many times.  `value` follows one random walk through the layers, so it is an estimate without
// bias.  `pdf` is exact: `sample` chooses between a reflection at the boundary and a direction near
// those of the base, with densities in closed form.  So the walk's noise never enters a weight.
// [Guo18], [Pharr23, 14.3]
#pragma once

#include <variant>

#include "server/materials/conductor.h"
#include "server/materials/dielectric.h"
#include "server/materials/diffuse.h"

namespace lucerna {

/// `Base`: Diffuse or Conductor.  Its index is relative to the coat.  Light from behind meets the
/// same layers.
template <std::floating_point Real, typename Base>
class Coated {
 public:
  static constexpr Side kSides = Side::kReflected;

  /// `thickness`: the coat's optical depth; light along the normal keeps exp(-thickness).
  struct Params {
    Dielectric<Real> boundary;
    Base base;
    Real thickness{};
  };
  explicit Coated(const Params& params);

  bool all_delta() const { return boundary_.all_delta() && base_.all_delta(); }
  Rgb<Real> single(const Vec3<Real>& wo, Side side) const;
  Rgb<Real> value(const Vec3<Real>& wo, const Vec3<Real>& wi) const;
  SolidAnglePdf<Real> pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const;
  std::optional<ScatterSample<Real>> sample(const Vec3<Real>& wo,
                                            const ScatterValues<Real>& u) const;

 private:
  static constexpr bool kMetal = std::is_same_v<Base, Conductor<Real>>;

  /// Probability of a reflection at the boundary.
  Real at_boundary(const Vec3<Real>& wo) const;
  /// Density of the directions near those of the base.
  Real base_pdf(const Vec3<Real>& wo, const Vec3<Real>& wi) const;
  Rgb<Real> walk(const Vec3<Real>& wo, const Vec3<Real>& wi) const;
  Real passes(Real cosine) const { return std::exp(-thickness_ / std::fabs(cosine)); }
  ScatterSample<Real> mirror(const Vec3<Real>& wo) const;

  Dielectric<Real> boundary_;
  Base base_;
  Conductor<Real> guide_;  ///< its directions are near those of a coated metal
  Real thickness_;
};

template <std::floating_point Real>
using CoatedDiffuse = Coated<Real, Diffuse<Real>>;
template <std::floating_point Real>
using CoatedConductor = Coated<Real, Conductor<Real>>;

}  // namespace lucerna
