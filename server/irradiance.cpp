// Irradiance at points: the first vertex of a path whose surface reflects everything, times pi.
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>

#include "server/block_stream.h"
#include "server/denormals.h"
#include "server/parallel.h"
#include "server/path.h"
#include "server/sample_sum.h"
#include "server/spectral_values.h"

namespace lucerna {
namespace {

constexpr std::uint32_t kSamplesBetweenPolls = 64;
// Of one chunk of points: about a millisecond.
constexpr std::uint64_t kSamplesPerChunk = 1024;

/// One number being estimated: the total, or one light's share of it.
struct Estimate {
  BlockStream<3> blocks{0};
  SampleSum block_sum;            // [lx], of the samples of the current block
  Rgb<double> exact;              // what needs no sampling [lx]
  double largest_unshadowed = 0;  // of one sample's illuminance had nothing been in the way [lx]
  bool sampled = false;

  void add(const LightEstimate& e) {
    block_sum.add(e.value);
    largest_unshadowed = std::max(largest_unshadowed, luminance(e.unshadowed));
  }
  void end_block(std::uint32_t samples) {
    const Rgb<double> v = block_sum.value() / samples;
    blocks.add({v.r, v.g, v.b});
    block_sum = {};
  }
  IrradianceEstimate result(double block_count, double samples_per_block) const;
};

IrradianceEstimate Estimate::result(double block_count, double samples_per_block) const {
  IrradianceEstimate e;
  e.irradiance_lx = exact;
  e.exact = !sampled;
  if (!sampled) return e;
  const auto total = blocks.total();
  const auto mean = [&](int i) { return total[i].sum / block_count; };
  const Rgb<double> sampled_mean{mean(0), mean(1), mean(2)};
  e.irradiance_lx += sampled_mean;
  const auto standard_error = [&](int i) {
    return block_count > 1 ? std::sqrt(total[i].deviation / (block_count * (block_count - 1)))
                           : std::numeric_limits<double>::infinity();
  };
  e.standard_error_lx = {standard_error(0), standard_error(1), standard_error(2)};
  // Rule of three: where N samples were all 0, with 95% confidence fewer than 3/N of all samples
  // are not; none of them seen could have been larger than the largest without its obstacle.
  // Where nothing was in the way of anything, there was nothing to miss.
  if (sampled_mean.is_black() && largest_unshadowed > 0)
    e.zero_bound_lx = luminance(exact) +
                      std::min(1.0, 3 / (block_count * samples_per_block)) * largest_unshadowed;
  return e;
}

/// Light of one point by the spectrum of the lights that it came from [lx]: [0] from lights that
/// were given RGB, [1 + k] from those of the scene's spectrum k.  Empty where nobody asks.
using BySpectrum = std::vector<SampleSum>;

class IrradianceJob {
 public:
  IrradianceJob(const Scene& scene, std::span<const IrradiancePoint> points,
                const IrradianceSettings& settings, const std::stop_token& stop,
                IrradianceResult& result)
      : scene_(scene),
        points_(points),
        settings_(settings),
        tracer_(scene, settings.bounces, settings.area_sampling),
        stop_(stop),
        result_(result),
        visit_all_(settings.per_light || tracer_.visits_all()),
        gather_indirect_(settings.bounces.value_or(1) > 0 && !scene.empty() &&
                         !scene.lights().empty()),
        gather_(gather_indirect_ || scene.has_visible_lights()),
        spectral_([this] { return SpectralValues(scene_, settings_.wavelengths_nm); }) {}

  void range(std::size_t begin, std::size_t end) {
    const DenormalsAreZero denormals;
    WorkCounts work;
    for (std::size_t p = begin; p < end && !stopped_; ++p) point(p, work);
    const std::lock_guard lock(mutex_);
    result_.work += work;
  }

  bool stopped() const { return stopped_; }

 private:
  void point(std::size_t p, WorkCounts& work) {
    if (stop_.stop_requested()) {
      stopped_ = true;
      return;
    }
    SurfaceHit receiver;
    receiver.position = points_[p].position;
    receiver.position_error = points_[p].position_error;
    receiver.ns = points_[p].normal;
    receiver.ng = Vec3<double>(receiver.ns);
    receiver.time_s = settings_.time_s;

    const std::size_t lights = scene_.lights().size();
    Estimate total;
    std::vector<Estimate> shares(settings_.per_light ? lights : 0);
    BySpectrum exact(settings_.wavelengths_nm.empty() ? 0 : scene_.spectra().size() + 1);
    BySpectrum sampled(exact.size());
    if (visit_all_) exact_lights(receiver, total, shares, exact, work);
    total.sampled = gather_ || (!visit_all_ && lights > 0);
    for (std::uint32_t b = 0; total.sampled && b < settings_.block_count; ++b) {
      const SobolSequence sequence(settings_.seed, settings_.first_item + p, b);
      for (std::uint32_t i = 0; i < settings_.samples_per_block; ++i) {
        if (i % kSamplesBetweenPolls == 0 && stop_.stop_requested()) {
          stopped_ = true;
          return;
        }
        sample(receiver, {sequence, i}, total, shares, sampled, work);
      }
      work.samples += settings_.samples_per_block;
      total.end_block(settings_.samples_per_block);
      for (Estimate& share : shares)
        if (share.sampled) share.end_block(settings_.samples_per_block);
    }
    result_.points[p] = total.result(settings_.block_count, settings_.samples_per_block);
    for (std::size_t l = 0; l < shares.size(); ++l)
      result_.per_light[p * lights + l] =
          shares[l].result(settings_.block_count, settings_.samples_per_block);
    if (!exact.empty()) put_spectral(p, exact, sampled);
  }

  void put_spectral(std::size_t p, const BySpectrum& exact, const BySpectrum& sampled) {
    SpectralValues& spectral = spectral_.local();
    const std::span<double> at(result_.spectral.data() + p * spectral.size(), spectral.size());
    const double samples = double(settings_.block_count) * settings_.samples_per_block;
    for (std::uint32_t g = 0; g < exact.size(); ++g) {
      std::optional<std::uint32_t> spectrum;
      if (g > 0) spectrum = g - 1;
      spectral.add(spectrum, exact[g].value() + sampled[g].value() / samples, at);
    }
  }

  void add_to(BySpectrum& groups, std::uint32_t light, const Rgb<double>& lx) const {
    if (groups.empty()) return;
    const auto number = scene_.spectrum_number(light);
    groups[number ? *number + 1 : 0].add(lx);
  }

  bool is_delta(std::size_t light) const {
    return std::visit([](const auto& l) { return l.kDelta; }, scene_.lights()[light].light);
  }

  // Delta lights have one direction each: one ray answers for them.
  void exact_lights(const SurfaceHit& receiver, Estimate& total, std::vector<Estimate>& shares,
                    BySpectrum& exact, WorkCounts& work) const {
    for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
      if (is_delta(l)) {
        const Rgb<double> e =
            tracer_.direct(receiver, receiver.ns, l, 1, {}, work).value * std::numbers::pi;
        total.exact += e;
        add_to(exact, l, e);
        if (!shares.empty()) shares[l].exact = e;
      } else if (!shares.empty()) {
        shares[l].sampled = true;
      }
    }
  }

  void sample(const SurfaceHit& receiver, const PathSample& s, Estimate& total,
              std::vector<Estimate>& shares, BySpectrum& sampled, WorkCounts& work) const {
    constexpr double kPi = std::numbers::pi;
    const Vec3<float>& n = receiver.ns;
    LightEstimate sum;
    const auto add = [&](std::uint32_t light, const LightEstimate& e) {
      const LightEstimate lx{e.value * kPi, e.unshadowed * kPi};
      sum.value += lx.value;
      sum.unshadowed += lx.unshadowed;
      if (!shares.empty()) shares[light].add(lx);
      add_to(sampled, light, lx.value);
    };
    if (visit_all_) {
      for (std::uint32_t l = 0; l < scene_.lights().size(); ++l)
        if (!is_delta(l))
          add(l, tracer_.direct(receiver, n, l, 1, s.pair(PathSample::kFirstVisited + l), work));
    } else {
      const auto chosen = tracer_.direct_of_chosen(receiver, n, 0, s, work);
      add(chosen.light, chosen.estimate);
    }
    if (gather_) {
      const Vec3<float> wi = PathTracer::cosine_direction(n, n, s.at(0, PathSample::kDirection));
      const double pdf = dot(n, wi) * std::numbers::inv_pi;
      const Ray ray = spawn_ray(receiver, wi);
      ++work.indirect_rays;
      const std::optional<SurfaceHit> hit = scene_.closest_hit(ray);
      tracer_.for_each_emitter(ray, hit, [&](std::uint32_t light, const Rgb<double>& le) {
        const double probability = visit_all_ ? 1 : tracer_.candidate_probability(light);
        const Rgb<double> e =
            le * tracer_.found_weight(receiver, n, ray, hit, light, probability, pdf);
        add(light, {e, e});
      });
      // What lies behind an obstacle counts as hidden: a light that is sampled by what exceeds its
      // mean may have nothing else to show.
      if (hit)
        tracer_.for_each_emitter(
            ray, std::nullopt, [&](std::uint32_t light, const Rgb<double>& le) {
              const double probability = visit_all_ ? 1 : tracer_.candidate_probability(light);
              add(light, {{},
                          le * tracer_.found_weight(receiver, n, ray, std::nullopt, light,
                                                    probability, pdf)});
            });
      if (hit && gather_indirect_) {
        const LightEstimate e = tracer_.reflected(*hit, -wi, 1, s, work);
        sum.value += e.value * kPi;
        sum.unshadowed += e.unshadowed * kPi;
      }
    }
    total.add(sum);
  }

  const Scene& scene_;
  std::span<const IrradiancePoint> points_;
  const IrradianceSettings& settings_;
  PathTracer tracer_;
  const std::stop_token& stop_;
  IrradianceResult& result_;
  const bool visit_all_, gather_indirect_, gather_;
  /// One for each thread that takes part, as looking spectra up takes longer than using them.
  tbb::enumerable_thread_specific<SpectralValues> spectral_;
  std::mutex mutex_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace

IrradianceResult estimate_irradiance(const Scene& scene, std::span<const IrradiancePoint> points,
                                     const IrradianceSettings& settings, std::stop_token stop) {
  IrradianceResult result;
  result.points.resize(points.size());
  if (settings.per_light) result.per_light.resize(points.size() * scene.lights().size());
  result.spectral.resize(points.size() * settings.wavelengths_nm.size());
  IrradianceJob job(scene, points, settings, stop, result);
  const std::uint64_t samples_per_point =
      std::uint64_t{settings.block_count} * settings.samples_per_block;
  const std::size_t grain = std::max<std::uint64_t>(1, kSamplesPerChunk / samples_per_point);
  parallel_chunks(points.size(), grain, stop,
                  [&](std::size_t begin, std::size_t end) { job.range(begin, end); });
  result.stopped = job.stopped() || stop.stop_requested();
  return result;
}

}  // namespace lucerna
