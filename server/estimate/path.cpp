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

}  // namespace

/// How a path goes on.
struct PathTracer::Direction {
  Vec3f wi;
  double pdf = 0;          ///< [1/sr]
  bool is_single = false;  ///< one of the surface's single directions, such as a mirror's
};

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

/// A path at its current vertex, with the light found so far.
struct PathTracer::Path {
  const PathSample& sample;
  WorkCounts& work;
  SurfaceHit hit;
  Vec3f wo;
  std::uint32_t depth;
  SmoothLight::Before before;
  /// Its vertices find lamps with a size by way of mirrors.  Later in a picture that costs more
  /// than it gains.
  bool is_of_receiver;
  Rgb throughput{1};
  LightEstimate sum{};
  LightSet exact{};  ///< lights that arrive at the vertex in closed form
  /// Unset where the surface is diffuse without textures, as most are.
  std::optional<SurfaceScattering> scattering{};

  const SurfaceScattering* surface() const { return scattering ? &*scattering : nullptr; }
  /// Whether light samples can arrive: a surface with single directions alone needs no lights.
  bool takes_samples() const { return !scattering || !scattering->all_delta(); }
  bool counts_sizes() const { return is_of_receiver || depth == 0; }
  void add(const LightEstimate& e, double weight = 1) {
    sum.value += throughput * e.value * weight;
    sum.unshadowed += throughput * e.unshadowed * weight;
  }
};

LightEstimate PathTracer::reflected(const SurfaceHit& first, const Vec3f& wo, std::uint32_t depth,
                                    const PathSample& sample, WorkCounts& work,
                                    SmoothLight::Before before,
                                    const NeighbourRays* neighbours) const {
  if (scene_.lights().empty()) return {};
  Path p{sample, work, first, wo, depth, before, depth > 0};
  for (;; ++p.depth) {
    if (const Rgb* reflectance = scene_.geometry().plain_diffuse(p.hit.material)) [[likely]] {
      p.scattering.reset();
      p.throughput = p.throughput * *reflectance;
      if (p.throughput.is_black()) return p.sum;
    } else {
      p.scattering.emplace(scene_, p.hit, direct_.transmittance().met(), neighbours);
      neighbours = nullptr;  // later surfaces are not met by a camera ray
    }
    if (p.depth == 0 && !p.scattering && direct_.uses_closed_forms(false)) add_closed_forms(p);
    const bool last = p.depth >= last_depth_;
    Direction next;
    // Before the lights are sampled: while those wait for square roots and divisions, the
    // processor computes this.
    if (!p.scattering && !(last && !direct_.finds_lights())) next = diffuse_direction(p);
    if (p.takes_samples()) add_samples(p);
    if (p.scattering && !scatter(p, next)) return p.sum;
    p.before = next.is_single
                   ? smooth_.after_single(p.before, p.hit, Vec3(p.wo), Vec3(next.wi))
                   : SmoothLight::Before{p.hit.position, next.pdf, false,
                                         smooth_.counts_at(p.counts_sizes(), p.surface(), p.wo)};
    // Lights do not sample single directions, so these always find lights.
    const bool finds = next.is_single ? scene_.lights().has_visible() : direct_.finds_lights();
    if ((last && !finds) || !survives(p)) return p.sum;
    const std::optional<SurfaceHit> end = follow(p, next, finds);
    if (!end || last) return p.sum;
    p.hit = *end;
    p.wo = -next.wi;
    p.exact.clear();
  }
}

void PathTracer::add_closed_forms(Path& p) const {
  for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
    const auto all = direct_.in_closed_form(p.hit, p.wo, l);
    if (!all) continue;
    p.exact.add(l);
    p.add({*all, *all});
  }
}

auto PathTracer::diffuse_direction(const Path& p) -> Direction {
  const Vec3f wi =
      cosine_direction(Vec3f(p.hit.ns), p.wo, p.sample.at(p.depth, PathSample::kDirection));
  return {wi, std::fabs(dot(p.hit.ns, Vec3(wi))) * std::numbers::inv_pi};
}

/// Adds the light that samples of lights find, also by way of smooth surfaces.
void PathTracer::add_samples(Path& p) const {
  const bool any_smooth = smooth_.any();
  const auto add = [&](std::uint32_t light, const LightEstimate& e) {
    p.add(e, any_smooth ? smooth_.glossy_weight(p.before, p.hit, light) : 1);
  };
  direct_.strategy(p.depth).sample(
      direct_, {p.hit, p.wo, p.depth, p.exact, p.work, add, p.surface()}, p.sample);
  if (!any_smooth) return;
  // Where a surface has both kinds of directions, paths come from its other ones too.
  const SmoothLight::Vertex v{
      p.hit, p.wo, p.surface(), p.depth, false, most_steps(p.depth), p.counts_sizes()};
  const auto found = [&](std::uint32_t, const LightEstimate& e) { p.add(e); };
  smooth_.sample(v, p.sample, p.work, found);
  smooth_.sample_glossy(v, p.sample, p.work, found);
}

/// Draws a direction of a surface that is not plain.  False: the path ends.
bool PathTracer::scatter(Path& p, Direction& next) {
  const Vec2f u = p.sample.at(p.depth, PathSample::kDirection);
  const auto scattered = p.scattering->sample(
      Vec3(p.wo), {p.sample.pair(PathSample::kFirstLobe + p.depth).x, {u.x, u.y}});
  if (!scattered) return false;
  p.throughput = p.throughput * scattered->weight;
  next = {Vec3f(scattered->wi), scattered->pdf.per_sr, scattered->delta};
  return !p.throughput.is_black() && is_finite(p.throughput);
}

/// Russian roulette.
bool PathTracer::survives(Path& p) const {
  if (p.depth < (endless_ ? kSafeDepth : kLongDepth)) return true;
  // Below 1 even if nothing is absorbed, so that every path ends.
  const double survival = std::min(0.95, p.throughput.max_component() / kWeight);
  if (p.sample.at(p.depth, PathSample::kSurvival).x >= survival) return false;
  p.throughput = p.throughput / survival;
  return true;
}

/// The next surface.  `finds`: adds the light at the end of the ray.
std::optional<SurfaceHit> PathTracer::follow(Path& p, const Direction& next, bool finds) const {
  const Ray ray = spawn_ray(p.hit, next.wi);
  ++p.work.indirect_rays;
  const std::optional<SurfaceHit> end = scene_.closest_hit(ray, direct_.transmittance().met());
  if (scene_.geometry().has_media()) p.throughput = p.throughput * left_by_media(ray, end);
  if (!finds) return end;
  for_each_emitter(scene_, ray, end, [&](std::uint32_t light, const Rgb& le) {
    if (p.exact.has(light) || (next.is_single && smooth_.counts(p.before, light))) return;
    p.work.by_chance += next.is_single ? p.before.met_unsolved : next.pdf > kNarrow;
    p.add({le, le}, next.is_single ? 1
                                   : direct_.found_weight(direct_.strategy(p.depth), p.hit, p.wo,
                                                          ray, end, light, next.pdf, p.surface()));
  });
  return end;
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
