#include "server/estimate/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/sampling/sampling.h"

namespace lucerna {
namespace {

/// From this depth on, Russian roulette ends paths for any requested number of bounces.  2^32
/// bounces between surfaces that do not absorb would take minutes.
constexpr std::uint32_t kLongDepth = 256;

/// How a path goes on.
struct Direction {
  Vec3f wi;
  double pdf = 0;          ///< [1/sr]
  bool is_single = false;  ///< one of the surface's single directions, such as a mirror's
};

}  // namespace

Vec3f PathTracer::cosine_direction(const Vec3f& ns, const Vec3f& wo, Vec2f u) {
  const Vec2f d = sample_concentric_disk(u);
  // At least one ulp above the surface, because directions within the surface have density 0.
  const float z = std::max(std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y)), 0x1p-24f);
  const Vec3f n = dot(ns, wo) < 0 ? -ns : ns;
  return Framef::around(n).world_from_local({d.x, d.y, z});
}

Rgb PathTracer::left_by_media(Ray ray, const std::optional<SurfaceHit>& end) const {
  if (end) ray.t_max = end->t;
  return scene_.geometry().through_media(ray);
}

LightEstimate PathTracer::reflected(const SurfaceHit& first, const Vec3f& first_wo,
                                    std::uint32_t depth, const PathSample& sample, WorkCounts& work,
                                    SmoothLight::Before before,
                                    const NeighbourRays* neighbours) const {
  LightEstimate sum;
  if (scene_.lights().empty()) return sum;
  SurfaceHit hit = first;
  Vec3f wo = first_wo;
  Rgb throughput{1};
  LightSet exact;
  // Later in a picture, samples of lamps with a size by way of mirrors cost more than they gain.
  const bool is_of_receiver = depth > 0;
  // Most surfaces are diffuse without textures, and need no scattering function.  Outside of the
  // loop, because GCC clears all of it.
  std::optional<SurfaceScattering> scattering;
  for (;; ++depth) {
    scattering.reset();
    if (const Rgb* reflectance = scene_.geometry().plain_diffuse(hit.material)) [[likely]] {
      throughput = throughput * *reflectance;
      if (throughput.is_black()) return sum;
    } else {
      scattering.emplace(scene_, hit, direct_.transmittance().met(), neighbours);
      neighbours = nullptr;  // later surfaces are not met by a camera ray
    }
    if (depth == 0 && !scattering && direct_.uses_closed_forms(false)) {
      for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
        const auto all = direct_.in_closed_form(hit, wo, l);
        if (!all) continue;
        exact.add(l);
        sum += {throughput * *all, throughput * *all};
      }
    }

    const bool last = depth >= last_depth_;
    Direction next_direction;
    if (!scattering && !(last && !direct_.finds_lights())) {
      // Before the lights are sampled: while those wait for square roots and divisions, the
      // processor computes this.
      next_direction.wi =
          cosine_direction(Vec3f(hit.ns), wo, sample.at(depth, PathSample::kDirection));
      next_direction.pdf = std::fabs(dot(hit.ns, Vec3(next_direction.wi))) * std::numbers::inv_pi;
    }

    const SurfaceScattering* const surface = scattering ? &*scattering : nullptr;
    if (surface == nullptr || !surface->all_delta()) {
      const auto add = [&](std::uint32_t light, const LightEstimate& e) {
        const double weight = smooth_.any() ? smooth_.glossy_weight(before, hit, light) : 1;
        sum.value += throughput * e.value * weight;
        sum.unshadowed += throughput * e.unshadowed * weight;
      };
      direct_.strategy(depth).sample(direct_, {hit, wo, depth, exact, work, add, surface}, sample);
    }

    // Where a surface has both kinds of directions, paths come from its other ones too.
    if (smooth_.any() && (surface == nullptr || !surface->all_delta())) {
      const SmoothLight::Vertex v{
          hit, wo, surface, depth, false, most_steps(depth), is_of_receiver || depth == 0};
      const auto found = [&](std::uint32_t, const LightEstimate& e) {
        sum.value += throughput * e.value;
        sum.unshadowed += throughput * e.unshadowed;
      };
      smooth_.sample(v, sample, work, found);
      smooth_.sample_glossy(v, sample, work, found);
    }

    if (scattering) {
      const auto scattered =
          scattering->sample(Vec3(wo), {sample.pair(PathSample::kFirstLobe + depth).x,
                                        {sample.at(depth, PathSample::kDirection).x,
                                         sample.at(depth, PathSample::kDirection).y}});
      if (!scattered) return sum;
      throughput = throughput * scattered->weight;
      if (throughput.is_black() || !is_finite(throughput)) return sum;
      next_direction = {Vec3f(scattered->wi), scattered->pdf.per_sr, scattered->delta};
    }
    if (!next_direction.is_single)
      before = {hit.position, next_direction.pdf, false,
                smooth_.counts_at(is_of_receiver || depth == 0, surface, wo)};
    else
      before = smooth_.after_single(before, hit, Vec3(wo), Vec3(next_direction.wi));
    // Lights do not sample single directions, so these always find lights.
    const bool finds =
        next_direction.is_single ? scene_.lights().has_visible() : direct_.finds_lights();
    if (last && !finds) return sum;
    if (depth >= (endless_ ? kSafeDepth : kLongDepth)) {
      // Below 1 even if nothing is absorbed, so that every path ends.
      const double survival = std::min(0.95, throughput.max_component() / kWeight);
      if (sample.at(depth, PathSample::kSurvival).x >= survival) return sum;
      throughput = throughput / survival;
    }

    const Vec3f& wi = next_direction.wi;
    const Ray ray = spawn_ray(hit, wi);
    ++work.indirect_rays;
    const std::optional<SurfaceHit> next = scene_.closest_hit(ray, direct_.transmittance().met());
    if (scene_.geometry().has_media()) throughput = throughput * left_by_media(ray, next);
    const auto found = [&](std::uint32_t light, const Rgb& le) {
      if (exact.has(light) || (next_direction.is_single && smooth_.counts(before, light))) return;
      work.by_chance +=
          next_direction.is_single ? before.met_unsolved : next_direction.pdf > kNarrow;
      const double weight = next_direction.is_single
                                ? 1
                                : direct_.found_weight(direct_.strategy(depth), hit, wo, ray, next,
                                                       light, next_direction.pdf, surface);
      sum.value += throughput * le * weight;
      sum.unshadowed += throughput * le * weight;
    };
    if (finds) for_each_emitter(scene_, ray, next, found);
    if (!next || last) return sum;
    hit = *next;
    wo = -wi;
    exact.clear();
  }
}

LightEstimate PathTracer::radiance(const Ray& ray, const PathSample& sample, WorkCounts& work,
                                   const NeighbourRays* neighbours) const {
  ++work.camera_rays;
  const std::optional<SurfaceHit> hit = scene_.closest_hit(ray, direct_.transmittance().met());
  Rgb seen;
  for_each_emitter(scene_, ray, hit, [&](std::uint32_t, const Rgb& le) { seen += le; });
  LightEstimate sum{seen, seen};
  if (hit) sum += reflected(*hit, -ray.direction, 0, sample, work, {}, neighbours);
  if (!scene_.geometry().has_media()) return sum;
  const Rgb left = left_by_media(ray, hit);
  return {sum.value * left, sum.unshadowed * left};
}

}  // namespace lucerna
