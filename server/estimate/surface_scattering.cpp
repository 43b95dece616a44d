#include "server/estimate/surface_scattering.h"

#include <algorithm>
#include <map>

namespace lucerna {
namespace {

/// A frame about the unit vector `n` whose first axis is near dpdu.
Frame frame_along(const Vec3& n, const SceneGeometry::ShadingPoint& at, FrameAlong second) {
  const Vec3 along = normalized(at.dpdu);
  const Vec3 s = along - n * dot(along, n);
  // A direction along the normal tells nothing.
  constexpr double kLeast = 1e-6;
  if (!(length(s) > kLeast)) return Frame::around(n);
  const Vec3 x = normalized(s);
  const Vec3 y = cross(n, x);
  return {x, second == FrameAlong::kV && dot(y, at.dpdv) < 0 ? -y : y, n};
}

/// The normal of the surface with its bumps.  The height is differentiated over a small step, as in
/// pbrt-v4.  [Pharr23, 10.5.3]
Vec3 bumped_normal(const Textures& textures, std::int32_t bumps,
                   const SceneGeometry::ShadingPoint& at) {
  constexpr double kStep = 0.0005;  // of u and v
  const Vec3& n = at.texture.normal;
  const auto height = [&](double du, double dv) {
    TexturePoint p = at.texture;
    p.uv = {p.uv.x + du, p.uv.y + dv};
    p.position += at.dpdu * du + at.dpdv * dv;
    return textures(NumberValue{0, bumps}, p);
  };
  const double here = height(0, 0);
  const Vec3 dpdu = at.dpdu + n * ((height(kStep, 0) - here) / kStep),
             dpdv = at.dpdv + n * ((height(0, kStep) - here) / kStep);
  const Vec3 bumped = normalized(cross(dpdu, dpdv));
  // (u, v) may have either handedness.
  return dot(bumped, n) < 0 ? -bumped : bumped;
}

/// Where the neighbours meet the plane of the surface, from the hit.
Footprint footprint_of(const NeighbourRays& rays, const SurfaceHit& hit,
                       const SceneGeometry::ShadingPoint& at) {
  const auto step = [&](const Ray& ray) {
    const Vec3 o = Vec3(ray.origin) - hit.position, d(ray.direction);
    return o - d * (dot(hit.ng, o) / dot(hit.ng, d));
  };
  // The (u, v) whose derivatives come nearest to a step on the surface.
  const double uu = dot(at.dpdu, at.dpdu), uv = dot(at.dpdu, at.dpdv), vv = dot(at.dpdv, at.dpdv);
  const double determinant = uu * vv - uv * uv, scale = determinant > 0 ? 1 / determinant : 0;
  const auto to_uv = [&](const Vec3& p) {
    const double u = dot(at.dpdu, p), v = dot(at.dpdv, p);
    return Vec2{(vv * u - uv * v) * scale, (uu * v - uv * u) * scale};
  };
  const Vec3 x = step(rays.x), y = step(rays.y);
  return {x, y, to_uv(x), to_uv(y)};
}

}  // namespace

SurfaceScattering::SurfaceScattering(const Scene& scene, SurfaceHit& hit, RayFilter filter,
                                     const NeighbourRays* neighbours) {
  if (filter == RayFilter::kPanesByChance && scene.geometry().is_pane(hit)) {
    is_mirror_ = true;
    frame_ = Frame::around(hit.ng);
    return;
  }
  SceneGeometry::ShadingPoint at = scene.geometry().shading_point(hit);
  Footprint footprint;
  if (neighbours != nullptr) {
    footprint = footprint_of(*neighbours, hit, at);
    at.texture.footprint = &footprint;
  }
  set(scene, hit, at,
      chosen(scene.geometry().materials(), hit.material, scene.geometry().textures(), at.texture));
}

void SurfaceScattering::set(const Scene& scene, SurfaceHit& hit,
                            const SceneGeometry::ShadingPoint& at, std::uint32_t number) {
  const Material& material = scene.geometry().materials()[number];
  bsdf_ = bsdf_of(material, scene.geometry().textures(), at.texture);
  frame_ = frame_along(hit.ns, at, material.second_axis);
  Vec3 n;
  if (material.normal_map >= 0) {
    const Rgb texel =
        scene.geometry().textures()(ColourValue{{}, material.normal_map}, at.texture) * 2 - Rgb(1);
    n = normalized(frame_.world_from_local(
        {texel.r * material.normal_scale, texel.g * material.normal_scale, texel.b}));
  } else if (material.bumps >= 0) {
    n = bumped_normal(scene.geometry().textures(), material.bumps, at);
  } else {
    return;
  }
  // A map does not turn the surface over.
  if (!(dot(n, hit.ng) > 0)) return;
  hit.ns = n;
  frame_ = frame_along(n, at, material.second_axis);
}

Rgb mean_single(const Scene& scene, const SurfaceHit& hit, const Vec3& wo, Side side) {
  const SceneGeometry::ShadingPoint at = scene.geometry().shading_point(hit);
  Rgb sum;
  // Parts of a mix have smaller numbers.  So each is visited once, with all of its shares.
  std::map<std::uint32_t, double> shares{{hit.material, 1}};
  while (!shares.empty()) {
    const auto [number, share] = *shares.rbegin();
    shares.erase(number);
    if (const auto* mix = std::get_if<MixParams>(&scene.geometry().materials()[number].params)) {
      const double amount =
          std::clamp(scene.geometry().textures()(mix->amount, at.texture), 0.0, 1.0);
      shares[mix->materials[0]] += share * (1 - amount);
      shares[mix->materials[1]] += share * amount;
      continue;
    }
    if (!(share > 0)) continue;
    SurfaceHit own = hit;
    SurfaceScattering scattering;
    scattering.set(scene, own, at, number);
    sum += scattering.single(wo, side) * share;
  }
  return sum;
}

std::optional<ScatterSample> SurfaceScattering::sample(const Vec3& wo,
                                                       const ScatterValues& u) const {
  const Vec3 w = local(wo);
  auto s = is_mirror_ ? ScatterSample{.wi = mirrored(w), .weight = Rgb(1), .delta = true}
                      : bsdf_.sample(w, u);
  if (s) s->wi = normalized(frame_.world_from_local(s->wi));
  return s;
}

}  // namespace lucerna
