// The microfacet distribution of rough surfaces: GGX, with different roughness along x and y.
// [Walter07], [Heitz14], and visible normals of [Heitz18b].
#pragma once

#include <cmath>
#include <numbers>

#include "lights/maths/density.h"
#include "lights/maths/vec.h"

namespace lucerna {

/// Normals m of microfacets, about the normal +z.  They are the normals of an ellipsoid with the
/// half axes 1/alpha_x, 1/alpha_y and 1.
class Microfacets {
 public:
  /// Both above 0.  From about 1 on the surface is as rough as it gets.
  Microfacets(double alpha_x, double alpha_y) : x_(alpha_x), y_(alpha_y) {}

  /// Below this roughness a surface counts as smooth, as in pbrt-v4.
  static constexpr double kSmooth = 1e-3;
  static bool is_smooth(double alpha_x, double alpha_y) {
    return std::fmax(alpha_x, alpha_y) < kSmooth;
  }
  /// The least roughness of a rough surface: along one axis it may be 0.
  static double rough(double alpha) { return std::fmax(alpha, 1e-4); }

  Vec2 alpha() const { return {x_, y_}; }

  /// Area of microfacets with normal `m` per area of the surface [1/sr].  m.z >= 0.
  double density(const Vec3& m) const {
    const double x = m.x / x_, y = m.y / y_, q = x * x + y * y + m.z * m.z;
    return std::numbers::inv_pi / (x_ * y_ * q * q);
  }
  /// The share of microfacets facing `w` that is not hidden behind others, over |w.z|.
  double seen_per_cosine(const Vec3& w) const { return 2 / (std::fabs(w.z) + stretched(w)); }
  /// The share of those seen from `wo` that `wi` sees too.
  double also_seen(const Vec3& wo, const Vec3& wi) const {
    // (1 + L_o) / (1 + L_o + L_i), with 1 + 2 L = stretched / |z|, multiplied by |z_o z_i|.
    const double o = std::fabs(wo.z), i = std::fabs(wi.z);
    const double of_o = (o + stretched(wo)) * i, of_i = (stretched(wi) - i) * o;
    return of_o > 0 ? of_o / (of_o + of_i) : 0.0;
  }
  /// Density of `sample` [1/sr].
  SolidAnglePdf pdf(const Vec3& w, const Vec3& m) const {
    return {seen_per_cosine(w) * density(m) * std::fmax(0.0, dot(w, m))};
  }
  /// A normal with the density of those that `w` sees.  w.z > 0.
  Vec3 sample(const Vec3& w, Vec2 u) const;

 private:
  /// Length of `w` in the space where the ellipsoid is a sphere.
  double stretched(const Vec3& w) const {
    const double x = x_ * w.x, y = y_ * w.y;
    return std::sqrt(x * x + y * y + w.z * w.z);
  }
  double x_, y_;
};

}  // namespace lucerna
