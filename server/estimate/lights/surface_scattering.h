// How the surface at a hit scatters light.
#pragma once

#include <optional>

#include "server/materials/bsdf.h"
#include "server/scene/scene.h"

namespace lucerna {

/// The scattering function at a hit, for directions of the scene.  Surfaces that are diffuse and
/// have no textures need none: see Scene::plain_diffuse.
class SurfaceScattering {
 public:
  /// Evaluates the textures of the material.  Sets `hit.ns` if a map changes the normal.
  /// `meets`: what the ray met.  With kPanesByChance, a pane counts as a mirror.
  /// `neighbours`: of the camera ray that met the surface, for scenes whose textures use
  /// footprints; else null.
  SurfaceScattering(const Scene& scene, SurfaceHit& hit, Meets meets = Meets::kSurfaces,
                    const NeighbourRays* neighbours = nullptr);

  bool all_delta() const { return is_mirror_ || bsdf_.all_delta(); }
  /// Whether light from both sides reaches the eye.
  bool transmits() const { return has(bsdf_.sides(), Side::kTransmitted); }
  /// f |cos| for unit vectors that point away from the surface.
  Rgb<double> value(const Vec3<double>& wo, const Vec3<double>& wi) const {
    return bsdf_.value(local(wo), local(wi));
  }
  double pdf(const Vec3<double>& wo, const Vec3<double>& wi) const {
    return bsdf_.pdf(local(wo), local(wi)).per_sr;
  }
  /// `wi` is in the scene.
  std::optional<ScatterSample<double>> sample(const Vec3<double>& wo,
                                              const ScatterValues<double>& u) const;

 private:
  Vec3<double> local(const Vec3<double>& w) const { return frame_.local_from_world(w); }

  bool is_mirror_ = false;  ///< `bsdf_` is then not used
  Bsdf<double> bsdf_{Diffuse<double>(Rgb<double>(0))};
  Frame<double> frame_;
};

}  // namespace lucerna
