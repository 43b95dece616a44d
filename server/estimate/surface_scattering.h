// How the surface at a hit scatters light.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "server/materials/bsdf.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Directions whose density is above this leave a surface that is nearly a mirror [1/sr].
inline constexpr double kNarrow = 5;

/// The share of the light from `wi` that a diffuse surface of reflectance 1 sends towards `wo`:
/// cosine / pi.  0 if they are on different sides.
inline double reflected_share(const SurfaceHit& hit, const Vec3f& wo, const Vec3& wi) {
  const double cos_i = dot(hit.ns, wi);
  return cos_i * dot(hit.ns, Vec3(wo)) > 0 ? std::fabs(cos_i) * std::numbers::inv_pi : 0;
}

/// The scattering function at a hit, for directions of the scene.  Surfaces that are diffuse and
/// have no textures need none: see Scene::plain_diffuse.
class SurfaceScattering {
 public:
  /// Evaluates the textures of the material.  Sets `hit.ns` if a map changes the normal.
  /// `meets`: what the ray met.  With kPanesByChance, a pane counts as a mirror.
  /// `neighbours`: of the camera ray that met the surface, for scenes whose textures use
  /// footprints; else null.
  SurfaceScattering(const Scene& scene, SurfaceHit& hit, RayFilter filter = RayFilter::kSurfaces,
                    const NeighbourRays* neighbours = nullptr);

  bool all_delta() const { return is_mirror_ || bsdf_.all_delta(); }
  /// Whether light from both sides reaches the eye.
  bool transmits() const { return has(bsdf_.sides(), Side::kTransmitted); }
  /// f |cos| for unit vectors that point away from the surface.
  Rgb value(const Vec3& wo, const Vec3& wi) const { return bsdf_.value(local(wo), local(wi)); }
  double pdf(const Vec3& wo, const Vec3& wi) const {
    return bsdf_.pdf(local(wo), local(wi)).per_sr;
  }
  /// The share of light that its single direction on a side sends to `wo`.
  Rgb single(const Vec3& wo, Side side) const { return bsdf_.single(local(wo), side); }
  /// Whether it scatters light so widely that samples of lights are enough.
  bool is_wide(const Vec3& wo) const {
    constexpr double kMost = 1;  // [1/sr]; a diffuse surface has 1/pi
    const Vec3 w = local(wo);
    return !all_delta() && bsdf_.pdf(w, mirrored(w)).per_sr <= kMost;
  }
  /// `wi` is in the scene.
  std::optional<ScatterSample> sample(const Vec3& wo, const ScatterValues& u) const;

 private:
  SurfaceScattering() = default;
  void set(const Scene& scene, SurfaceHit& hit, const SceneGeometry::ShadingPoint& at,
           std::uint32_t material);
  friend Rgb mean_single(const Scene& scene, const SurfaceHit& hit, const Vec3& wo, Side side);
  Vec3 local(const Vec3& w) const { return frame_.local_from_world(w); }

  bool is_mirror_ = false;  ///< `bsdf_` is then not used
  Bsdf bsdf_{Diffuse(Rgb(0))};
  Frame frame_;
};

/// SurfaceScattering::single(), as the mean over the materials of a mix.  At one point, chance
/// takes one of them.
Rgb mean_single(const Scene& scene, const SurfaceHit& hit, const Vec3& wo, Side side);

}  // namespace lucerna
