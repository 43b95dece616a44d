// The irradiance at a point is computed as the first vertex of a path.  Its surface reflects all
// light; the result is multiplied by pi.
#include "server/queries/receiver_irradiance.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "server/estimate/manifold_walks.h"
#include "server/estimate/missed_light.h"
#include "server/estimate/path.h"
#include "server/estimate/pilots.h"
#include "server/estimate/spectral_values.h"
#include "server/queries/exact_light.h"
#include "server/queries/irradiance_estimate.h"
#include "server/runtime/parallel.h"
#include "server/visibility/shadow_edges.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kSamplesBetweenPolls = 64;
// A chunk takes 0.1 to 10 ms; a sample takes 0.5 to 40 us.
constexpr std::uint64_t kSamplesPerChunk = 256;
// The same if each light takes one ray and no sample.
constexpr std::size_t kRaysPerChunk = 8192;
// A walk takes as long as 10 to 40 samples; so many find nearly every path.
constexpr std::uint32_t kSamplesPerWalk = 2, kMostWalks = 32;

/// A point whose light is estimated.
struct Item {
  std::size_t number;
  SurfaceHit receiver;
  Vec3f n;  // its normal
  ExactPart exact;
};

/// Sums over all samples of one point.
struct Sampled {
  Estimate total;
  LightSet found;                // lights of which a sample found light, shadowed or not
  std::vector<Estimate> shares;  // of each light, with `per_light`
  // Of the current sample, to which a light may add light in several ways [lx].
  std::vector<LightEstimate> sample_shares;    // of each light
  std::vector<std::uint32_t> lit_shares;       // lights that added some
  BySpectrum by_spectrum;                      // of the current block
  std::vector<BlockStream<1>> at_wavelengths;  // [W/m2/nm]
  FoundLight reflected;
};

/// Whether reflected light is part of the answer.
bool gathers_reflected_light(const Scene& scene, const IrradianceSettings& settings) {
  return settings.bounces.value_or(1) > 0 && !scene.geometry().empty() && !scene.lights().empty();
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
        exact_(scene, settings, tracer_, gather_indirect_),
        walks_(scene, direct_.visibility(), tracer_.smooth()),
        by_walks_(gather_indirect_ && walks_.any()),
        missed_(scene, settings.bounces),
        confidence_(settings.target ? settings.target->confidence : kConfidence),
        rule_(confidence_, settings.block_count,
              std::max<std::uint64_t>(samples_of(settings.samples_per_block), 1)),
        spectral_([this] { return SpectralValues(scene_, settings_.wavelengths_nm); }) {}

  std::size_t points_per_chunk() const {
    const std::size_t lights = std::max<std::size_t>(1, scene_.lights().size());
    if (!gather_indirect_ && direct_.is_exact())
      return std::max<std::size_t>(1, kRaysPerChunk / lights);
    if (settings_.target) return 1;
    return std::max<std::size_t>(1, kSamplesPerChunk / (samples_of(settings_.samples_per_block) +
                                                        ExactLight::kSamplesPerShafts));
  }

  void point(std::size_t p, WorkCounts& work) {
    if (stopped_ || stop_.stop_requested()) {
      stopped_ = true;
      return;
    }
    // Times points only with a target; otherwise all take equally many samples.
    std::chrono::steady_clock::time_point start;
    if (settings_.target) start = std::chrono::steady_clock::now();
    const std::uint64_t rays_before = work.indirect_rays + work.shadow_rays;
    const SurfaceHit receiver = surface_at(points_[p], settings_.time_s);
    std::uint32_t per_block = settings_.samples_per_block;
    const std::uint64_t expected = settings_.target
                                       ? std::min(kFirstPilotSamples, samples_of(most_per_block()))
                                       : samples_of(per_block);
    Item item{p, receiver, Vec3f(receiver.ns), exact_.at(receiver, expected, work)};
    if (settings_.target && item.exact.needs_samples) per_block = needed_per_block(item, work);
    put_exact(item);
    std::uint64_t samples = 0;
    if (item.exact.needs_samples && !stopped_) {
      Sampled e = no_samples(item.exact.shares.size(), settings_.wavelengths_nm.size());
      blocks(item, {0, settings_.block_count, per_block}, e, work);
      if (stopped_) return;
      samples = samples_of(per_block);
      put_sampled(item, e, samples);
    }
    if (stopped_) return;
    MissedLight& missed = result_.points[p].missed;
    if (missed.kind == MissedLight::Kind::kNone && missed_.is_outdoors(item.receiver))
      missed.kind = MissedLight::Kind::kOutdoors;
    std::chrono::duration<double> took{};
    if (settings_.target) took = std::chrono::steady_clock::now() - start;
    result_.costs[p] = {samples, work.indirect_rays + work.shadow_rays - rays_before, took.count()};
  }

 private:
  /// The samples in a block that this point needs for the target error.  Sets its exact part to
  /// that of this number.
  std::uint32_t needed_per_block(Item& item, WorkCounts& work) {
    std::uint32_t per_block = by_pilots(item, work);
    if (direct_.draws_deltas(*item.exact.strategy) &&
        &exact_.strategy(samples_of(per_block)) != item.exact.strategy) {
      // With this many samples, rays to all delta lights cost less.
      item.exact = exact_.at(item.receiver, samples_of(per_block), work);
      if (item.exact.needs_samples) per_block = by_pilots(item, work);
    }
    // A query with this sample count and no target must have the same exact part.  So the count is
    // raised to the least one that has it.
    if (&exact_.strategy(samples_of(per_block)) != item.exact.strategy)
      per_block = static_cast<std::uint32_t>(
          (direct_.samples_for_exact_deltas() + settings_.block_count - 1) / settings_.block_count);
    return per_block;
  }

  void put_exact(Item& item) {
    const std::size_t lights = item.exact.shares.size();
    set_exact(item.exact.lx, result_.points[item.number]);
    for (std::size_t l = 0; l < lights; ++l)
      set_exact(item.exact.shares[l], result_.per_light[item.number * lights + l]);
    if (item.exact.by_spectrum.wanted())
      item.exact.by_spectrum.put(spectral_.local(), 1, spectral(item));
  }

  /// Adds sampled light to the exact part.
  void put_sampled(const Item& item, const Sampled& e, std::uint64_t samples) {
    const std::size_t p = item.number;
    std::optional<IntervalRule> own;
    if (settings_.target) own.emplace(confidence_, settings_.block_count, samples);
    const IntervalRule& rule = own ? *own : rule_;
    const double count = settings_.block_count;
    IrradianceEstimate& total = result_.points[p];
    total = e.total.result(item.exact.lx, count, rule,
                           [&](bool missed) { return most(item, missed ? &e.found : nullptr); });
    if (gather_indirect_) {
      total.missed = missed_.at(item.receiver, e.reflected, rule);
      // An interval that ends above the answer has room for reflected light.
      constexpr double kRounded = 1e-9;
      if (total.missed.kind == MissedLight::Kind::kReflected &&
          total.illuminance_lx.upper > luminance(total.irradiance_lx) * (1 + kRounded))
        total.missed = {};
      total.illuminance_lx.upper += total.missed.bound_lx;
      if (total.zero_bound_lx > 0) total.zero_bound_lx = total.illuminance_lx.upper;
    }
    for (std::uint32_t l = 0; l < e.shares.size(); ++l)
      if (is_sampled(item, l))
        result_.per_light[p * e.shares.size() + l] =
            e.shares[l].result(item.exact.shares[l], count, rule, [&](bool missed) {
              return missed || item.exact.lights.has(l) ? MostIrradiance{} : most(item, l);
            });
    add_shadow_edges(item, e);
    const std::span<double> at_wavelengths = spectral(item);
    for (std::size_t k = 0; k < at_wavelengths.size(); ++k) {
      const BlockStatistics at = e.at_wavelengths[k].total()[0];
      at_wavelengths[k] += at.sum / count;
      if (count > 1)
        result_.spectral_error[p * at_wavelengths.size() + k] = standard_error(at, count);
    }
  }

  /// Adds to intervals what the rounding of edges may change.
  void add_shadow_edges(const Item& item, const Sampled& e) {
    const auto widen = [](IrradianceEstimate& to, double lx) {
      to.illuminance_lx.lower = std::max(0.0, to.illuminance_lx.lower - lx);
      to.illuminance_lx.upper += lx;
    };
    const std::size_t p = item.number;
    for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
      if (!e.found.has(l) || item.exact.lights.has(l)) continue;
      const double lx = light_at_shadow_edges(scene_, item.receiver, l, most(item, l).lx);
      if (!(lx > 0)) continue;
      widen(result_.points[p], lx);
      if (settings_.per_light) widen(result_.per_light[p * scene_.lights().size() + l], lx);
    }
  }

  /// Upper bounds of the direct light of the lights that are not exact.  `found`: leaves out these
  /// lights; then 0 if lights are drawn, because many are never drawn.  Reflected light has no
  /// bound.
  MostIrradiance most(const Item& item, const LightSet* found) const {
    MostIrradiance sum;
    if (found != nullptr && item.exact.strategy != &direct_.all_lights()) return sum;
    for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
      if (item.exact.lights.has(l) || (found != nullptr && found->has(l))) continue;
      const MostIrradiance one = most(item, l);
      sum.lx += one.lx, sum.sample_lx += one.sample_lx;
    }
    return sum;
  }
  MostIrradiance most(const Item& item, std::uint32_t light) const {
    return direct_.most(*item.exact.strategy, item.receiver, item.n, light);
  }

  /// Whether samples find light of this light: directly, or by way of smooth surfaces.
  bool is_sampled(const Item& item, std::uint32_t light) const {
    return by_way_ || by_walks_ || !item.exact.lights.has(light);
  }

  /// Entries of a point, one for each wavelength.
  std::span<double> spectral(const Item& item) {
    const std::size_t n = settings_.wavelengths_nm.size();
    return {result_.spectral.data() + item.number * n, n};
  }

  std::uint64_t samples_of(std::uint32_t per_block) const {
    return std::uint64_t{per_block} * settings_.block_count;
  }
  std::uint32_t most_per_block() const {
    return most_samples_per_block(*settings_.target, settings_.block_count);
  }
  Sampled no_samples(std::size_t shares, std::size_t wavelengths) const {
    const Estimate none{.may_be_hidden = !scene_.geometry().is_clear()};
    return {none,
            {},
            std::vector<Estimate>(shares, none),
            std::vector<LightEstimate>(shares),
            {},
            exact_.no_spectra(),
            std::vector<BlockStream<1>>(wavelengths, BlockStream<1>(0)),
            {}};
  }
  void blocks(const Item& item, const Blocks& these, Sampled& e, WorkCounts& work) {
    const std::uint64_t number =
        settings_.first_item +
        (settings_.numbers.empty() ? item.number : settings_.numbers[item.number]);
    const std::uint64_t by_chance = work.by_chance, cut_short = work.cut_short;
    for (std::uint64_t b = 0; b < these.count; ++b) {
      const SampleSequence sequence(settings_.methods.sampler, settings_.seed, number,
                                    these.first + b);
      for (std::uint32_t i = 0; i < these.samples; ++i) {
        if (i % kSamplesBetweenPolls == 0 && stop_.stop_requested()) {
          stopped_ = true;
          return;
        }
        sample(item, {sequence, i}, e, work);
      }
      if (by_walks_) walk(item, {sequence, 0}, these.samples, e, work);
      work.samples += these.samples;
      e.total.end_block(these.samples);
      for (std::uint32_t l = 0; l < e.shares.size(); ++l)
        if (is_sampled(item, l)) e.shares[l].end_block(these.samples);
      if (!e.at_wavelengths.empty()) end_spectral_block(these.samples, e);
    }
    e.reflected.by_chance = work.by_chance - by_chance;
    e.reflected.cut_short = work.cut_short - cut_short;
  }

  void end_spectral_block(std::uint32_t samples, Sampled& e) {
    SpectralValues& spectral = spectral_.local();
    std::vector<double> at(e.at_wavelengths.size());
    e.by_spectrum.put(spectral, 1.0 / samples, at);
    for (std::size_t k = 0; k < at.size(); ++k) e.at_wavelengths[k].add({at[k]});
  }

  /// The samples in a block that pilots choose.
  std::uint32_t by_pilots(const Item& item, WorkCounts& work) {
    const std::uint32_t count = settings_.block_count;
    return needed_samples_per_block(
        *settings_.target, count, [&](const Blocks& these) -> std::optional<PilotEstimate> {
          Sampled pilot = no_samples(0, 0);
          blocks(item, these, pilot, work);
          if (stopped_) return std::nullopt;
          const IntervalRule rule(confidence_, count, these.count * these.samples);
          const IrradianceEstimate e = pilot.total.result(
              item.exact.lx, static_cast<double>(these.count), rule,
              [&](bool missed) { return most(item, missed ? &pilot.found : nullptr); });
          return PilotEstimate{luminance(e.irradiance_lx), e.illuminance_lx};
        });
  }

  /// One sample of the light that is not exact.
  void sample(const Item& item, const PathSample& s, Sampled& to, WorkCounts& work) const {
    LightEstimate sum;
    const auto add_light = [&](std::uint32_t light, const LightEstimate& e) {
      add(light, e, sum, to);
    };
    item.exact.strategy->sample(direct_,
                                {item.receiver, item.n, 0, item.exact.lights, work, add_light}, s);
    if (by_way_) {
      const SmoothLight::Vertex v{
          item.receiver,      item.n, nullptr, 0, true, tracer_.most_steps(0), true,
          settings_.per_light};
      tracer_.smooth().sample(v, s, work, add_light);
      tracer_.smooth().sample_glossy(v, s, work, [&](std::uint32_t, const LightEstimate& e) {
        add_reflected(e, Rgb(1), sum, to);
      });
    }
    if (item.exact.gathers) {
      gather(PathTracer::cosine_direction(item.n, item.n, s.at(0, PathSample::kDirection)), false,
             item, s, sum, to, work);
      if (item.exact.guided.any()) {
        const Vec3f wi = item.exact.guided.sample(s.pair(PathSample::kGuided));
        if (dot(item.n, wi) > 0) gather(wi, true, item, s, sum, to, work);
      }
    }
    to.total.add(sum);
    for (const std::uint32_t light : to.lit_shares)
      to.shares[light].add(std::exchange(to.sample_shares[light], {}));
    to.lit_shares.clear();
  }

  /// Adds light by way of curved smooth surfaces to a block.
  void walk(const Item& item, const PathSample& s, std::uint32_t samples, Sampled& to,
            WorkCounts& work) const {
    walks_.sample(item.receiver, std::clamp(samples / kSamplesPerWalk, 1U, kMostWalks),
                  tracer_.most_steps(0), s, work, [&](std::uint32_t light, const Rgb& lx) {
                    to.total.add_to_block(lx, samples);
                    if (!to.shares.empty()) to.shares[light].add_to_block(lx, samples);
                    exact_.add_to(to.by_spectrum, light, lx * static_cast<double>(samples));
                  });
  }

  /// Adds the light of one light to the sum and to the light's share of the sample.
  void add(std::uint32_t light, const LightEstimate& e, LightEstimate& sum, Sampled& to) const {
    const LightEstimate lx{e.value * kPi, e.unshadowed * kPi};
    sum += lx;
    exact_.add_to(to.by_spectrum, light, lx.value);
    if (lx.unshadowed.is_black()) return;
    to.found.add(light);
    if (to.shares.empty()) return;
    if (to.sample_shares[light].unshadowed.is_black()) to.lit_shares.push_back(light);
    to.sample_shares[light] += lx;
  }

  /// Adds light that surfaces reflect, of which `left` arrives.
  static void add_reflected(const LightEstimate& e, const Rgb& left, LightEstimate& sum,
                            Sampled& to) {
    sum += {e.value * left * kPi, e.unshadowed * left * kPi};
    to.reflected.reflected += e.unshadowed.is_black() ? 0 : 1;
  }

  /// Adds the light that a direction of the receiver finds: lights, and light that surfaces
  /// reflect.  `is_guided`: it was drawn for surfaces that are not plain; light from these counts
  /// with the balance heuristic of both ways.  [Veach95]
  void gather(const Vec3f& wi, bool is_guided, const Item& item, const PathSample& s,
              LightEstimate& sum, Sampled& to, WorkCounts& work) const {
    const GuidedDirections& guided = item.exact.guided;
    const double pdf = dot(item.n, wi) * std::numbers::inv_pi;
    const Ray ray = spawn_ray(item.receiver, wi);
    ++work.indirect_rays;
    const std::optional<SurfaceHit> hit = scene_.closest_hit(ray, direct_.transmittance().met());
    const bool both =
        guided.any() && hit && scene_.geometry().plain_diffuse(hit->material) == nullptr;
    if (is_guided && !both) return;
    Rgb left(1);
    if (both) left = left * (pdf / (pdf + guided.pdf(wi)));
    if (scene_.geometry().has_media()) left = left * tracer_.left_by_media(ray, hit);
    const auto weight = [&](std::uint32_t light, const std::optional<SurfaceHit>& end) {
      return item.exact.lights.has(light)
                 ? 0.0
                 : direct_.found_weight(*item.exact.strategy, item.receiver, item.n, ray, end,
                                        light, pdf);
    };
    if (direct_.finds_lights()) {
      for_each_emitter(scene_, ray, hit, [&](std::uint32_t light, const Rgb& le) {
        const Rgb e = le * left * weight(light, hit);
        add(light, {e, e}, sum, to);
      });
      // Light behind an obstacle counts as hidden.  Light samples may choose only values above a
      // light's mean.  Then only this shows that the light exists.
      if (hit && !is_guided)
        for_each_emitter(scene_, ray, std::nullopt, [&](std::uint32_t light, const Rgb& le) {
          add(light, {{}, le * weight(light, std::nullopt)}, sum, to);
        });
    }
    if (hit && gather_indirect_) {
      const LightEstimate e = tracer_.reflected(
          *hit, -wi, 1, s, work,
          {item.receiver.position, pdf, true, tracer_.smooth().counts_at(true, nullptr, item.n)});
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
  const ExactLight exact_;
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
  IrradianceEstimator estimator(scene, points, settings, stop, result);
  result.work = parallel_work(points.size(), estimator.points_per_chunk(), stop,
                              [&](std::size_t begin, std::size_t end, WorkCounts& work) {
                                for (std::size_t p = begin; p < end; ++p) estimator.point(p, work);
                              });
  result.stopped = stop.stop_requested();
  return result;
}

}  // namespace lucerna
