// Glass, water and the like: boundaries that reflect and refract, and thin panes.
#pragma once

#include "server/materials/microfacet.h"
#include "server/materials/scattering.h"

namespace lucerna {

/// A boundary between two dielectrics, smooth or microfaceted.  [Walter07], [Pharr23, 9.5, 9.7]
class Dielectric {
 public:
  static constexpr Side sides() { return Side::kBoth; }
  /// `eta`: the index on the side to which -z points, over that to which +z points; above 0.
  /// Roughness as in Conductor.  A boundary of equal indices is smooth.
  Dielectric(double eta, double alpha_x, double alpha_y)
      : eta_(eta),
        facets_(Microfacets::rough(alpha_x), Microfacets::rough(alpha_y)),
        smooth_(eta == 1 || Microfacets::is_smooth(alpha_x, alpha_y)) {}

  double eta() const { return eta_; }
  bool all_delta() const { return smooth_; }
  Rgb single(const Vec3& wo, Side side) const;
  Vec2 alpha() const { return facets_.alpha(); }
  Rgb value(const Vec3& wo, const Vec3& wi) const { return Rgb(value(wo, wi, Carries::kRadiance)); }
  SolidAnglePdf pdf(const Vec3& wo, const Vec3& wi) const { return {pdf(wo, wi, Side::kBoth)}; }
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const;

  /// The same for one side only, and for the quantity that a path carries.  Layers need them.
  double value(const Vec3& wo, const Vec3& wi, Carries carries) const;
  double pdf(const Vec3& wo, const Vec3& wi, Side sides) const;
  struct Sample {
    Vec3 wi;
    double weight = 0;  ///< as in ScatterSample
    double pdf = 0;
    bool delta = false;
  };
  std::optional<Sample> sample(const Vec3& wo, const ScatterValues& u, Side sides,
                               Carries carries) const;

 private:
  double eta_;
  Microfacets facets_;
  bool smooth_;
};

/// A pane so thin that light leaves it where it entered, in its direction.  Includes the
/// reflections between its two sides.  [Pharr23, 9.5.2]
class ThinDielectric {
 public:
  static constexpr Side sides() { return Side::kBoth; }
  explicit ThinDielectric(double eta) : eta_(eta) {}

  bool all_delta() const { return true; }
  Rgb single(const Vec3& wo, Side side) const {
    return Rgb(side == Side::kTransmitted ? passed(wo.z) : 1 - passed(wo.z));
  }
  Rgb value(const Vec3&, const Vec3&) const { return {}; }
  SolidAnglePdf pdf(const Vec3&, const Vec3&) const { return {}; }
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const;
  /// The share of light that passes straight on; the rest is reflected.
  double passed(double cosine) const;

 private:
  double eta_;
};

}  // namespace lucerna
