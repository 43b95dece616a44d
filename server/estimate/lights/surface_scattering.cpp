#include "server/estimate/lights/surface_scattering.h"

namespace lucerna {
namespace {

/// A frame about the unit vector `n` whose first axis is near `dpdu`.
Frame<double> frame_along(const Vec3<double>& n, const Vec3<double>& dpdu) {
  const Vec3<double> along = normalized(dpdu);
  const Vec3<double> s = along - n * dot(along, n);
  // A direction along the normal tells nothing.
  constexpr double kLeast = 1e-6;
  if (!(length(s) > kLeast)) return Frame<double>::around(n);
  const Vec3<double> x = normalized(s);
  return {x, cross(n, x), n};
}

}  // namespace

SurfaceScattering::SurfaceScattering(const Scene& scene, SurfaceHit& hit) {
  const Scene::ShadingPoint at = scene.shading_point(hit);
  const std::uint32_t number =
      chosen(scene.materials(), hit.material, scene.textures(), at.texture);
  const Material& material = scene.materials()[number];
  bsdf_ = bsdf_of(material, scene.textures(), at.texture);
  frame_ = frame_along(normalized(Vec3<double>(hit.ns)), at.dpdu);
  if (material.normal_map < 0) return;
  const Rgb<double> texel =
      scene.textures()(ColourValue{{}, material.normal_map}, at.texture) * 2 - Rgb<double>(1);
  const Vec3<double> n = normalized(frame_.world_from_local(
      {texel.r * material.normal_scale, texel.g * material.normal_scale, texel.b}));
  // A map does not turn the surface over.
  if (!(dot(n, hit.ng) > 0)) return;
  hit.ns = Vec3<float>(n);
  frame_ = frame_along(n, at.dpdu);
}

std::optional<ScatterSample<double>> SurfaceScattering::sample(
    const Vec3<double>& wo, const ScatterValues<double>& u) const {
  auto s = bsdf_.sample(local(wo), u);
  if (s) s->wi = normalized(frame_.world_from_local(s->wi));
  return s;
}

}  // namespace lucerna
