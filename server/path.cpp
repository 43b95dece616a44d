#include "server/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/sampling.h"

namespace lucerna {
namespace {

constexpr double kInvPi = std::numbers::inv_pi;

/// Reflections from which on Russian roulette ends paths however many were asked for: between
/// surfaces that absorb nothing 2^32 of them would take minutes.
constexpr std::uint32_t kLongDepth = 256;

/// The power heuristic's weight of the strategy with density `a` against `b`, without overflow.
double power_weight(double a, double b) {
  if (!(a > 0)) return 0;
  const double ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

}  // namespace

Vec3<float> PathTracer::cosine_direction(const Vec3<float>& ns, const Vec3<float>& wo,
                                         Vec2<float> u) {
  const Vec2<float> d = sample_concentric_disk(u);
  // At least one ulp above the surface: the density of a direction within it is 0.
  const float z = std::max(std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y)), 0x1p-24f);
  const Vec3<float> n = dot(ns, wo) < 0 ? -ns : ns;
  return Frame<float>::around(n).world_from_local({d.x, d.y, z});
}

Receiver<double> PathTracer::receiver(const SurfaceHit& hit, const Vec3<float>& wo) const {
  Receiver<double> r(hit.position);
  r.normal = Vec3<double>(dot(hit.ns, wo) < 0 ? -hit.ns : hit.ns);
  r.area_sampling = methods_.area_sampling;
  // Wherever a light is sampled here a direction of the surface is too, and both are weighed.
  r.incomplete = true;
  return r;
}

PathTracer::Candidate PathTracer::candidate(const SurfaceHit& hit, const Vec3<float>& wo,
                                            std::uint32_t light, double probability,
                                            Vec2<float> u) const {
  Candidate c{visit_light(scene_.lights()[light], hit.time_s,
                          [&](const auto& l) {
                            return l.sample_li(receiver(hit, wo), {u.x, u.y});
                          }),
              {}};
  const LightSample<double>& s = c.sample;
  if (s.reason != NoLight::kNone) return c;
  const double cos_i = dot(Vec3<double>(hit.ns), s.wi);
  if (!(cos_i * dot(hit.ns, wo) > 0)) return c;
  const double f = std::fabs(cos_i) * kInvPi;  // also the density of cosine_direction
  if (s.delta) {
    c.value = s.value * (f / probability);
  } else {
    const double light_pdf = s.pdf.per_sr * probability;
    c.value = s.value * (f * power_weight(light_pdf, f) / light_pdf);
  }
  return c;
}

LightEstimate PathTracer::shadowed(const SurfaceHit& hit, std::uint32_t light,
                                   const LightSample<double>& sample, const Rgb<double>& value,
                                   WorkCounts& work) const {
  if (value.is_black()) return {};
  ++work.shadow_rays;
  const Ray ray = shadow_ray(hit, sample, scene_.lights()[light].reach_m);
  return {scene_.occluded(ray) ? Rgb<double>{} : value, value};
}

LightEstimate PathTracer::direct(const SurfaceHit& hit, const Vec3<float>& wo, std::uint32_t light,
                                 double probability, Vec2<float> u, WorkCounts& work) const {
  const Candidate c = candidate(hit, wo, light, probability, u);
  return shadowed(hit, light, c.sample, c.value, work);
}

PathTracer::ChosenLight PathTracer::direct_of_chosen(const SurfaceHit& hit, const Vec3<float>& wo,
                                                     std::uint32_t depth, const PathSample& sample,
                                                     WorkCounts& work) const {
  if (scene_.lights().size() == 1)
    return {0, direct(hit, wo, 0, 1, sample.at(depth, PathSample::kLightPoint), work)};
  // One pass over the candidates, each replacing the one kept so far with the probability of its
  // share in the sum.  [Chao82]
  double u = sample.at(depth, PathSample::kSurvival).y;
  double sum = 0;
  ChosenLight chosen{};
  Candidate kept{};
  const auto weigh = [&](std::uint32_t light, const Candidate& c) {
    const double importance = c.value.max_component();
    if (!(importance > 0)) return;
    sum += importance;
    const double share = importance / sum;
    if (u < share) {
      u /= share;
      kept = c;
      chosen.light = light;
    } else {
      u = (u - share) / (1 - share);
    }
  };
  const auto lights = static_cast<std::uint32_t>(scene_.lights().size());
  if (visits_all()) {
    // The same point for all: they need not be independent, since one of them is kept.
    const Vec2<float> point = sample.at(depth, PathSample::kLightPoint);
    for (std::uint32_t l = 0; l < lights; ++l) weigh(l, candidate(hit, wo, l, 1, point));
  } else {
    for (std::uint32_t j = 0; j < kCandidates; ++j) {
      const PathSample s = sample.part(j, kCandidates);
      const Vec2<float> v = s.at(depth, PathSample::kLight);
      const LightChoice choice = choose_light(scene_, choosing_value(v));
      weigh(choice.light, candidate(hit, wo, choice.light, choice.probability,
                                    s.at(depth, PathSample::kLightPoint)));
    }
    sum /= kCandidates;
  }
  if (sum > 0 && std::isfinite(sum)) {
    const double scale = sum / kept.value.max_component();
    chosen.estimate = shadowed(hit, chosen.light, kept.sample, kept.value * scale, work);
  }
  return chosen;
}

double PathTracer::found_weight(const SurfaceHit& from, const Vec3<float>& wo, const Ray& ray,
                                const std::optional<SurfaceHit>& hit, std::uint32_t light,
                                double probability, double direction_pdf) const {
  const SolidAnglePdf<double> pdf =
      visit_light(scene_.lights()[light], ray.time_s, [&]<typename L>(const L& l) {
        if constexpr (SeenOnSurface<L>)
          return hit ? l.pdf_li(receiver(from, wo), hit->on_light()) : SolidAnglePdf<double>{};
        else
          return l.pdf_li(receiver(from, wo), Vec3<double>(ray.direction));
      });
  return power_weight(direction_pdf, pdf.per_sr * probability);
}

LightEstimate PathTracer::reflected(const SurfaceHit& first, const Vec3<float>& first_wo,
                                    std::uint32_t depth, const PathSample& sample,
                                    WorkCounts& work) const {
  LightEstimate sum;
  if (scene_.lights().empty()) return sum;
  SurfaceHit hit = first;
  Vec3<float> wo = first_wo;
  Rgb<double> throughput{1};
  for (;; ++depth) {
    throughput = throughput * scene_.materials()[hit.material].reflectance;
    if (throughput.is_black()) return sum;

    const LightEstimate direct_light = direct_of_chosen(hit, wo, depth, sample, work).estimate;
    sum.value += throughput * direct_light.value;
    sum.unshadowed += throughput * direct_light.unshadowed;

    const bool last = depth >= last_depth_;
    if (last && !scene_.has_visible_lights()) return sum;
    if (depth >= (endless_ ? kSafeDepth : kLongDepth)) {
      // Below 1 even where nothing is absorbed, so that every path ends.
      const double survival = std::min(0.95, throughput.max_component());
      if (sample.at(depth, PathSample::kSurvival).x >= survival) return sum;
      throughput = throughput / survival;
    }

    const Vec3<float> wi = cosine_direction(hit.ns, wo, sample.at(depth, PathSample::kDirection));
    const double pdf = std::fabs(dot(hit.ns, wi)) * kInvPi;
    const Ray ray = spawn_ray(hit, wi);
    ++work.indirect_rays;
    const std::optional<SurfaceHit> next = scene_.closest_hit(ray);
    for_each_emitter(ray, next, [&](std::uint32_t light, const Rgb<double>& le) {
      const double weight =
          found_weight(hit, wo, ray, next, light, candidate_probability(light), pdf);
      sum.value += throughput * le * weight;
      sum.unshadowed += throughput * le * weight;
    });
    if (!next || last) return sum;
    hit = *next;
    wo = -wi;
  }
}

LightEstimate PathTracer::radiance(const Ray& ray, const PathSample& sample,
                                   WorkCounts& work) const {
  ++work.camera_rays;
  const std::optional<SurfaceHit> hit = scene_.closest_hit(ray);
  Rgb<double> seen;
  for_each_emitter(ray, hit, [&](std::uint32_t, const Rgb<double>& le) { seen += le; });
  if (!hit) return {seen, seen};
  const LightEstimate e = reflected(*hit, -ray.direction, 0, sample, work);
  return {seen + e.value, seen + e.unshadowed};
}

}  // namespace lucerna
