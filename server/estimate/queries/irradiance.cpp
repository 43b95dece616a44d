// The irradiance at a point is computed as the first vertex of a path.  Its surface reflects all
// light; the result is multiplied by pi.
#include "server/estimate/queries/irradiance.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numbers>

#include "server/estimate/lights/manifold_walks.h"
#include "server/estimate/paths/path.h"
#include "server/estimate/queries/irradiance_estimate.h"
#include "server/estimate/queries/missed_light.h"
#include "server/estimate/queries/settled_light.h"
#include "server/estimate/queries/shadow_edges.h"
#include "server/estimate/queries/spectral_values.h"
#include "server/estimate/statistics/pilots.h"
#include "server/runtime/denormals.h"
#include "server/runtime/parallel.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kSamplesBetweenPolls = 64;
// A chunk takes 0.1 to 10 ms; a sample takes 0.5 to 40 us.
constexpr std::uint64_t kSamplesPerChunk = 256;
// The same if each light takes one ray and no sample.
constexpr std::size_t kRaysPerChunk = 8192;
// A walk takes as long as 10 to 40 samples; so many find nearly every path.
constexpr std::uint32_t kSamplesPerWalk = 2, kMostWalks = 32;

/// Sums over all samples of one point.
struct Sampled {
  Estimate total;
  LightSet found;                // lights of which a sample found light, shadowed or not
  std::vector<Estimate> shares;  // of each light, with `per_light`
  BySpectrum by_spectrum;        // of the current block
  std::vector<BlockStream<1>> at_wavelengths;  // [W/m2/nm]
  std::uint64_t reflected = 0;                 // samples with light that surfaces reflect
};

/// Whether reflected light is part of the answer.
bool gathers_reflected_light(const Scene& scene, const IrradianceSettings& settings) {
  return settings.bounces.value_or(1) > 0 && !scene.empty() && !scene.lights().empty();
}

class IrradianceEstimator {
 public:
  IrradianceEstimator(const Scene& scene, std::span<const IrradiancePoint> points,
                      const IrradianceSettings& settings, const std::stop_token& stop,
                      IrradianceResult& result)
      : scene_(scene),
        points_(points),
        settings_(settings),
        tracer_(scene, settings.bounces, settings.methods),
        stop_(stop),
        result_(result),
        direct_(tracer_.direct()),
        gather_indirect_(gathers_reflected_light(scene, settings)),
        by_way_(gather_indirect_ && tracer_.smooth().any()),
        settler_(scene, settings, tracer_, gather_indirect_),
        walks_(scene, direct_.visibility(), tracer_.smooth()),
        by_walks_(gather_indirect_ && walks_.any()),
        missed_(scene, settings.bounces),
        confidence_(settings.target ? settings.target->confidence : kConfidence),
        rule_(confidence_, settings.block_count,
              std::max<std::uint64_t>(samples_of(settings.samples_per_block), 1)),
        spectral_([this] { return SpectralValues(scene_, settings_.wavelengths_nm); }) {}

  WorkCounts range(std::size_t begin, std::size_t end) {
    WorkCounts work;
    for (std::size_t p = begin; p < end && !stopped_; ++p) point(p, work);
    return work;
  }

  std::size_t points_per_chunk() const {
    const std::size_t lights = std::max<std::size_t>(1, scene_.lights().size());
    if (!gather_indirect_ && direct_.is_exact())
      return std::max<std::size_t>(1, kRaysPerChunk / lights);
    if (settings_.target) return 1;
    return std::max<std::size_t>(1, kSamplesPerChunk / (samples_of(settings_.samples_per_block) +
                                                        LightSettler::kSamplesPerShafts));
  }

 private:
  void point(std::size_t p, WorkCounts& work) {
    if (stop_.stop_requested()) {
      stopped_ = true;
      return;
    }
    // Times points only with a target; otherwise all take equally many samples.
    std::chrono::steady_clock::time_point start;
    if (settings_.target) start = std::chrono::steady_clock::now();
    const std::uint64_t rays_before = work.indirect_rays + work.shadow_rays;
    const SurfaceHit receiver = surface_at(points_[p], settings_.time_s);
    const std::uint64_t samples = put_estimate(p, receiver, work);
    if (stopped_) return;
    MissedLight& missed = result_.points[p].missed;
    if (missed.kind == MissedLight::Kind::kNone && missed_.is_outdoors(points_[p], receiver.time_s))
      missed.kind = MissedLight::Kind::kOutdoors;
    std::chrono::duration<double> took{};
    if (settings_.target) took = std::chrono::steady_clock::now() - start;
    result_.costs[p] = {samples, work.indirect_rays + work.shadow_rays - rays_before, took.count()};
  }

  /// Returns the number of samples of the estimate.
  std::uint64_t put_estimate(std::size_t p, const SurfaceHit& receiver, WorkCounts& work) {
    std::uint32_t per_block = settings_.samples_per_block;
    const std::uint64_t expected = settings_.target
                                       ? std::min(kFirstPilotSamples, samples_of(most_per_block()))
                                       : samples_of(per_block);
    Settled settled = settler_.settle(receiver, expected, work);
    if (settings_.target && settled.needs_samples) {
      per_block = needed_per_block(p, receiver, settled, work);
      if (settled.spending == Spending::kDrawn &&
          settler_.spending(samples_of(per_block)) != settled.spending) {
        // With this many samples, settling delta lights costs less.
        settled = settler_.settle(receiver, samples_of(per_block), work);
        if (settled.needs_samples) per_block = needed_per_block(p, receiver, settled, work);
      }
      // A query with this sample count and no target must settle the same lights.  So the count is
      // raised to the least one that settles them.
      if (settler_.spending(samples_of(per_block)) != settled.spending)
        per_block = settling_per_block();
    }
    put_exact(p, settled);
    if (!settled.needs_samples || stopped_) return 0;
    put_sampled(p, receiver, settled, per_block, work);
    return samples_of(per_block);
  }

  void put_exact(std::size_t p, Settled& settled) {
    set_exact(settled.exact, result_.points[p]);
    for (std::size_t l = 0; l < settled.shares.size(); ++l)
      set_exact(settled.shares[l], result_.per_light[p * settled.shares.size() + l]);
    if (settled.by_spectrum.wanted()) settled.by_spectrum.put(spectral_.local(), 1, spectral(p));
  }

  /// Samples the remaining light and adds it to the exact part.
  void put_sampled(std::size_t p, const SurfaceHit& receiver, const Settled& settled,
                   std::uint32_t per_block, WorkCounts& work) {
    Sampled e = no_samples(settled.shares.size(), settings_.wavelengths_nm.size());
    const std::uint64_t by_chance = work.by_chance, cut_short = work.cut_short;
    blocks(p, receiver, {0, settings_.block_count, per_block}, settled, e, work);
    if (stopped_) return;
    std::optional<IntervalRule> own;
    if (settings_.target) own.emplace(confidence_, settings_.block_count, samples_of(per_block));
    const IntervalRule& rule = own ? *own : rule_;
    const double count = settings_.block_count;
    result_.points[p] = e.total.result(settled.exact, count, rule, [&](bool missed) {
      return most(receiver, settled, missed ? &e.found : nullptr);
    });
    if (gather_indirect_) {
      IrradianceEstimate& total = result_.points[p];
      total.missed = missed_.at(
          points_[p], {work.by_chance - by_chance, work.cut_short - cut_short, e.reflected}, rule);
      // An interval that ends above the answer has room for reflected light.
      constexpr double kRounded = 1e-9;
      if (total.missed.kind == MissedLight::Kind::kReflected &&
          total.illuminance_lx.upper > luminance(total.irradiance_lx) * (1 + kRounded))
        total.missed = {};
      total.illuminance_lx.upper += total.missed.bound_lx;
      if (total.zero_bound_lx > 0) total.zero_bound_lx = total.illuminance_lx.upper;
    }
    for (std::uint32_t l = 0; l < e.shares.size(); ++l)
      if (is_sampled(settled, l))
        result_.per_light[p * e.shares.size() + l] =
            e.shares[l].result(settled.shares[l], count, rule, [&](bool missed) {
              return missed || settled.lights.has(l) ? MostIrradiance{}
                                                     : most(receiver, settled, l);
            });
    add_shadow_edges(p, receiver, settled, e);
    const std::span<double> at_wavelengths = spectral(p);
    for (std::size_t k = 0; k < at_wavelengths.size(); ++k) {
      const BlockStatistics at = e.at_wavelengths[k].total()[0];
      at_wavelengths[k] += at.sum / count;
      if (count > 1)
        result_.spectral_error[p * at_wavelengths.size() + k] =
            std::sqrt(at.deviation / (count * (count - 1)));
    }
  }

  /// Adds to intervals what the rounding of edges may change.
  void add_shadow_edges(std::size_t p, const SurfaceHit& receiver, const Settled& settled,
                        const Sampled& e) {
    const auto widen = [](IrradianceEstimate& to, double lx) {
      to.illuminance_lx.lower = std::max(0.0, to.illuminance_lx.lower - lx);
      to.illuminance_lx.upper += lx;
    };
    for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
      if (!e.found.has(l) || settled.lights.has(l)) continue;
      const double lx = light_at_shadow_edges(scene_, receiver, l, most(receiver, settled, l).lx);
      if (!(lx > 0)) continue;
      widen(result_.points[p], lx);
      if (settings_.per_light) widen(result_.per_light[p * scene_.lights().size() + l], lx);
    }
  }

  /// Upper bounds of the direct light of the lights that are not settled.  `found`: leaves out
  /// these lights; then 0 if lights are drawn, because many are never drawn.  Reflected light has
  /// no bound.
  MostIrradiance most(const SurfaceHit& receiver, const Settled& settled,
                      const LightSet* found) const {
    MostIrradiance sum;
    if (found != nullptr && settled.spending != Spending::kEach) return sum;
    for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
      if (settled.lights.has(l) || (found != nullptr && found->has(l))) continue;
      const MostIrradiance one = most(receiver, settled, l);
      sum.lx += one.lx, sum.sample_lx += one.sample_lx;
    }
    return sum;
  }
  MostIrradiance most(const SurfaceHit& receiver, const Settled& settled,
                      std::uint32_t light) const {
    return direct_.most(settled.spending, receiver, Vec3f(receiver.ns), light);
  }

  /// Whether samples find light of this light: directly, or by way of smooth surfaces.
  bool is_sampled(const Settled& settled, std::uint32_t light) const {
    return by_way_ || by_walks_ || !settled.lights.has(light);
  }

  /// Entries of point `p`, one for each wavelength.
  std::span<double> spectral(std::size_t p) {
    const std::size_t n = settings_.wavelengths_nm.size();
    return {result_.spectral.data() + p * n, n};
  }

  std::uint64_t samples_of(std::uint32_t per_block) const {
    return std::uint64_t{per_block} * settings_.block_count;
  }
  /// The largest `samples_per_block` within the target's limit.
  std::uint32_t most_per_block() const {
    return static_cast<std::uint32_t>(
        std::max<std::uint64_t>(1, settings_.target->max_samples / settings_.block_count));
  }
  /// The least `samples_per_block` for which delta lights are settled.
  std::uint32_t settling_per_block() const {
    return static_cast<std::uint32_t>((direct_.settling_samples() + settings_.block_count - 1) /
                                      settings_.block_count);
  }
  Sampled no_samples(std::size_t shares, std::size_t wavelengths) const {
    const Estimate none{.may_be_hidden = !scene_.is_clear()};
    return {none,
            {},
            std::vector<Estimate>(shares, none),
            settler_.no_spectra(),
            std::vector<BlockStream<1>>(wavelengths, BlockStream<1>(0))};
  }
  void blocks(std::size_t p, const SurfaceHit& receiver, const Blocks& these,
              const Settled& settled, Sampled& e, WorkCounts& work) {
    const std::uint64_t item =
        settings_.first_item + (settings_.numbers.empty() ? p : settings_.numbers[p]);
    for (std::uint64_t b = 0; b < these.count; ++b) {
      const SampleSequence sequence(settings_.methods.sampler, settings_.seed, item,
                                    these.first + b);
      for (std::uint32_t i = 0; i < these.samples; ++i) {
        if (i % kSamplesBetweenPolls == 0 && stop_.stop_requested()) {
          stopped_ = true;
          return;
        }
        sample(receiver, {sequence, i}, settled, e, work);
      }
      if (by_walks_) walk(receiver, {sequence, 0}, these.samples, e, work);
      work.samples += these.samples;
      e.total.end_block(these.samples);
      for (std::uint32_t l = 0; l < e.shares.size(); ++l)
        if (is_sampled(settled, l)) e.shares[l].end_block(these.samples);
      if (!e.at_wavelengths.empty()) end_spectral_block(these.samples, e);
    }
  }

  void end_spectral_block(std::uint32_t samples, Sampled& e) {
    SpectralValues& spectral = spectral_.local();
    std::vector<double> at(e.at_wavelengths.size());
    e.by_spectrum.put(spectral, 1.0 / samples, at);
    for (std::size_t k = 0; k < at.size(); ++k) e.at_wavelengths[k].add({at[k]});
  }

  /// The samples in a block that this point needs for the target error.
  std::uint32_t needed_per_block(std::size_t p, const SurfaceHit& receiver, const Settled& settled,
                                 WorkCounts& work) {
    const std::uint32_t replicates = settings_.block_count;
    const auto needed =
        needed_samples(*settings_.target, [&](const Blocks& these) -> std::optional<PilotEstimate> {
          Sampled pilot = no_samples(0, 0);
          blocks(p, receiver, these, settled, pilot, work);
          if (stopped_) return std::nullopt;
          const IntervalRule rule(confidence_, replicates, these.count * these.samples);
          const IrradianceEstimate e = pilot.total.result(
              settled.exact, static_cast<double>(these.count), rule, [&](bool missed) {
                return most(receiver, settled, missed ? &pilot.found : nullptr);
              });
          return PilotEstimate{luminance(e.irradiance_lx), e.illuminance_lx};
        });
    return static_cast<std::uint32_t>(std::min(static_cast<double>(most_per_block()),
                                               std::ceil(needed.value_or(1) / replicates)));
  }

  /// One sample of the light that is not settled.
  void sample(const SurfaceHit& receiver, const PathSample& s, const Settled& settled, Sampled& to,
              WorkCounts& work) const {
    LightEstimate sum;
    direct_.sample(settled.spending, receiver, Vec3f(receiver.ns), 0, s, settled.lights, work,
                   [&](std::uint32_t light, const LightEstimate& e) { add(light, e, sum, to); });
    if (by_way_) {
      const Vec3f n(receiver.ns);
      const SmoothLight::Vertex v{
          receiver, n, nullptr, 0, true, tracer_.most_steps(0), true, settings_.per_light};
      tracer_.smooth().sample(
          v, s, work, [&](std::uint32_t light, const LightEstimate& e) { add(light, e, sum, to); });
      tracer_.smooth().sample_glossy(v, s, work, [&](std::uint32_t, const LightEstimate& e) {
        add_reflected(e, Rgb(1), sum, to);
      });
    }
    if (settled.gathers) gather(receiver, s, settled, sum, to, work);
    to.total.add(sum);
  }

  /// Adds light by way of curved smooth surfaces to a block.
  void walk(const SurfaceHit& receiver, const PathSample& s, std::uint32_t samples, Sampled& to,
            WorkCounts& work) const {
    walks_.sample(receiver, std::clamp(samples / kSamplesPerWalk, 1U, kMostWalks),
                  tracer_.most_steps(0), s, work, [&](std::uint32_t light, const Rgb& lx) {
                    to.total.add_to_block(lx, samples);
                    if (!to.shares.empty()) to.shares[light].add_to_block(lx, samples);
                    settler_.add_to(to.by_spectrum, light, lx * static_cast<double>(samples));
                  });
  }

  /// Adds the light of one light to the sum and to the light's share.
  void add(std::uint32_t light, const LightEstimate& e, LightEstimate& sum, Sampled& to) const {
    const LightEstimate lx{e.value * kPi, e.unshadowed * kPi};
    sum += lx;
    if (!lx.unshadowed.is_black()) to.found.add(light);
    if (!to.shares.empty()) to.shares[light].add(lx);
    settler_.add_to(to.by_spectrum, light, lx.value);
  }

  /// Adds light that surfaces reflect, of which `left` arrives.
  static void add_reflected(const LightEstimate& e, const Rgb& left, LightEstimate& sum,
                            Sampled& to) {
    sum += {e.value * left * kPi, e.unshadowed * left * kPi};
    to.reflected += e.unshadowed.is_black() ? 0 : 1;
  }

  /// Adds the light that directions of the receiver find: lights, and light that surfaces reflect.
  void gather(const SurfaceHit& receiver, const PathSample& s, const Settled& settled,
              LightEstimate& sum, Sampled& to, WorkCounts& work) const {
    const Vec3f n(receiver.ns);
    gather_along(PathTracer::cosine_direction(n, n, s.at(0, PathSample::kDirection)), false,
                 receiver, s, settled, sum, to, work);
    if (!settled.guided.any()) return;
    const Vec3f wi = settled.guided.sample(s.pair(PathSample::kGuided));
    if (dot(n, wi) > 0) gather_along(wi, true, receiver, s, settled, sum, to, work);
  }
  /// The same for one direction.  `is_guided`: it was drawn for surfaces that are not plain; light
  /// from these counts with the balance heuristic of both ways. [Veach95]
  void gather_along(const Vec3f& wi, bool is_guided, const SurfaceHit& receiver,
                    const PathSample& s, const Settled& settled, LightEstimate& sum, Sampled& to,
                    WorkCounts& work) const {
    const Vec3f n(receiver.ns);
    const double pdf = dot(n, wi) * std::numbers::inv_pi;
    const Ray ray = spawn_ray(receiver, wi);
    ++work.indirect_rays;
    const std::optional<SurfaceHit> hit = scene_.closest_hit(ray, direct_.transmittance().met());
    const bool both = settled.guided.any() && hit && scene_.plain_diffuse(hit->material) == nullptr;
    if (is_guided && !both) return;
    Rgb left(1);
    if (both) left = left * (pdf / (pdf + settled.guided.pdf(wi)));
    if (scene_.has_media()) left = left * tracer_.left_by_media(ray, hit);
    const auto weight = [&](std::uint32_t light, const std::optional<SurfaceHit>& end) {
      return settled.lights.has(light)
                 ? 0.0
                 : direct_.found_weight(settled.spending, receiver, n, ray, end, light, pdf);
    };
    if (direct_.finds_lights()) {
      tracer_.for_each_emitter(ray, hit, [&](std::uint32_t light, const Rgb& le) {
        const Rgb e = le * left * weight(light, hit);
        add(light, {e, e}, sum, to);
      });
      // Light behind an obstacle counts as hidden.  Light samples may choose only values above a
      // light's mean.  Then only this shows that the light exists.
      if (hit && !is_guided)
        tracer_.for_each_emitter(ray, std::nullopt, [&](std::uint32_t light, const Rgb& le) {
          add(light, {{}, le * weight(light, std::nullopt)}, sum, to);
        });
    }
    if (hit && gather_indirect_) {
      const LightEstimate e = tracer_.reflected(
          *hit, -wi, 1, s, work,
          {receiver.position, pdf, true, tracer_.smooth().counts_at(true, nullptr, n)});
      add_reflected(e, left, sum, to);
    }
  }

  const Scene& scene_;
  std::span<const IrradiancePoint> points_;
  const IrradianceSettings& settings_;
  PathTracer tracer_;
  const std::stop_token& stop_;
  IrradianceResult& result_;
  const DirectLight& direct_;
  const bool gather_indirect_;
  const bool by_way_;  // of smooth surfaces, light is sampled
  const LightSettler settler_;
  const ManifoldWalks walks_;
  const bool by_walks_;  // of curved smooth surfaces, light of lamps without a size is sampled
  const MissedLightRule missed_;
  const double confidence_;
  const IntervalRule rule_;  ///< for points with the sample count of the settings
  /// One for each thread, because looking spectra up takes longer than using them.
  tbb::enumerable_thread_specific<SpectralValues> spectral_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace

IrradianceResult estimate_irradiance(const Scene& scene, std::span<const IrradiancePoint> points,
                                     const IrradianceSettings& settings, std::stop_token stop) {
  IrradianceResult result;
  if (points.empty()) return result;
  result.points.resize(points.size());
  if (settings.per_light) result.per_light.resize(points.size() * scene.lights().size());
  result.costs.resize(points.size());
  result.spectral.resize(points.size() * settings.wavelengths_nm.size());
  result.spectral_error.resize(result.spectral.size());
  std::mutex mutex;
  IrradianceEstimator estimator(scene, points, settings, stop, result);
  parallel_chunks(points.size(), estimator.points_per_chunk(), stop,
                  [&](std::size_t begin, std::size_t end) {
                    const DenormalsAreZero denormals;
                    const WorkCounts work = estimator.range(begin, end);
                    const std::lock_guard lock(mutex);
                    result.work += work;
                  });
  result.stopped = stop.stop_requested();
  return result;
}

}  // namespace lucerna
