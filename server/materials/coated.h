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
template <typename Base>
class Coated {
 public:
  static constexpr Side sides() { return Side::kReflected; }

  /// `thickness`: the coat's optical depth; light along the normal keeps exp(-thickness).
  struct Params {
    Dielectric boundary;
    Base base;
    double thickness{};
  };
  explicit Coated(const Params& params);

  bool all_delta() const { return boundary_.all_delta() && base_.all_delta(); }
  Rgb single(const Vec3& wo, Side side) const;
  Rgb value(const Vec3& wo, const Vec3& wi) const;
  SolidAnglePdf pdf(const Vec3& wo, const Vec3& wi) const;
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const;

 private:
  static constexpr bool kMetal = std::is_same_v<Base, Conductor>;

  /// Probability of a reflection at the boundary.
  double at_boundary(const Vec3& wo) const;
  /// Density of the directions near those of the base.
  double base_pdf(const Vec3& wo, const Vec3& wi) const;
  Rgb walk(const Vec3& wo, const Vec3& wi) const;
  double passes(double cosine) const { return std::exp(-thickness_ / std::fabs(cosine)); }
  ScatterSample mirror(const Vec3& wo) const;

  Dielectric boundary_;
  Base base_;
  Conductor guide_;  ///< its directions are near those of a coated metal
  double thickness_;
};

using CoatedDiffuse = Coated<Diffuse>;
using CoatedConductor = Coated<Conductor>;

}  // namespace lucerna
