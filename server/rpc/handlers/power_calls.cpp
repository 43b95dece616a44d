// EstimatePower.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "server/estimate/queries/queries.h"
#include "server/estimate/queries/sampled_power.h"
#include "server/estimate/queries/spectral_values.h"
#include "server/estimate/statistics/sample_sum.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/paging.h"
#include "server/rpc/messages/stop_rule.h"
#include "server/runtime/time_budget.h"

namespace lucerna::rpc {
namespace {

// Processor time of one item [s], rounded up from what one core took on the reference scenes.
constexpr double kPowerSeconds = 300e-9;
constexpr double kRaySeconds = 300e-9;
constexpr std::uint32_t kPowerSamples = 4096;  // of METHOD_SAMPLED

/// Power with what its spectrum tells of it.
struct RadiantPower {
  Power luminous;
  std::optional<SampledPower> sampled{};
  std::optional<double> watts{};
  std::vector<double> w_per_nm{};  // at each wavelength asked for
};

/// Of one light.  Finite whatever the light: a float's flux times at most kMostWattsPerLumen.
RadiantPower radiant_power(const Scene& scene, std::uint32_t light, const Power& luminous,
                           SpectralValues& spectral) {
  RadiantPower power{.luminous = luminous, .w_per_nm = std::vector<double>(spectral.size())};
  if (const Spectrum* spectrum = scene.spectrum(light)) {
    power.watts = luminance(luminous.lumens) * spectrum->watts_per_lumen();
  }
  spectral.add(light, luminous.lumens, power.w_per_nm);
  return power;
}

/// Of many lights, of any magnitudes: none is lost beside a larger one.
class PowerTotal {
 public:
  explicit PowerTotal(std::size_t wavelengths) : w_per_nm_(wavelengths) {}

  void add(const RadiantPower& power) {
    is_empty_ = false;
    lumens_.add(power.luminous.lumens);
    error_lumens_.add(power.luminous.error_lumens);
    has_watts_ = has_watts_ && power.watts;
    watts_.add(power.watts.value_or(0));
    for (std::size_t k = 0; k < w_per_nm_.size(); ++k) w_per_nm_[k].add(power.w_per_nm[k]);
  }
  /// It has watts as long as all that was added has.
  RadiantPower value() const {
    RadiantPower sum{.luminous = {lumens_.value(), error_lumens_.value()}};
    if (has_watts_ && !is_empty_) sum.watts = watts_.value();
    for (const CompensatedSum& at : w_per_nm_) sum.w_per_nm.push_back(at.value());
    return sum;
  }

 private:
  SampleSum lumens_;
  CompensatedSum error_lumens_, watts_;
  bool has_watts_ = true, is_empty_ = true;
  std::vector<CompensatedSum> w_per_nm_;
};

/// What no double held (squares of what lights at the ends of their domain send) is still a bound.
double held(double v) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  return v < kLargest ? v : kLargest;
}

void set_power(const RadiantPower& radiant, v1::LightPower* out) {
  const Power& power = radiant.luminous;
  if (radiant.sampled) {
    const SampledPower& sampled = *radiant.sampled;
    // A single sample has neither.
    if (std::isfinite(sampled.interval_lm.upper) || std::isfinite(sampled.standard_error_lm)) {
      out->set_standard_error_lm(held(sampled.standard_error_lm));
      out->set_lower_lm(sampled.interval_lm.lower > 0 ? held(sampled.interval_lm.lower) : 0);
      out->set_upper_lm(held(sampled.interval_lm.upper));
    }
    out->set_samples(sampled.samples);
  }
  out->mutable_rgb_lm()->set_r(power.lumens.r);
  out->mutable_rgb_lm()->set_g(power.lumens.g);
  out->mutable_rgb_lm()->set_b(power.lumens.b);
  out->set_power_lm(luminance(power.lumens));
  out->set_error_lm(power.error_lumens);
  if (radiant.watts) out->set_power_w(*radiant.watts);
  out->mutable_spectral_w_per_nm()->Add(radiant.w_per_nm.begin(), radiant.w_per_nm.end());
}

struct PowerWork {
  std::shared_ptr<const Scene> scene;
  std::size_t lights = 0;           // that are asked about
  std::size_t first = 0, page = 0;  // of these, in the answer
  std::span<const double> wavelengths_nm{};
  std::optional<StopRule> rule{};  // of METHOD_SAMPLED
  std::uint32_t most_samples = 0;  // with a time budget

  absl::Status operator()(const v1::EstimatePowerRequest& request, const std::stop_token& stop,
                          v1::EstimatePowerResponse* response) const;

 private:
  absl::StatusOr<std::vector<std::uint32_t>> which(const v1::EstimatePowerRequest& request) const;
  /// Nothing where it was stopped.
  std::optional<SampledPowers> sampled(std::uint64_t seed, std::span<const std::uint32_t> which,
                                       const std::stop_token& stop) const;
};

absl::StatusOr<std::vector<std::uint32_t>> PowerWork::which(
    const v1::EstimatePowerRequest& request) const {
  std::vector<std::uint32_t> all(lights);
  for (std::size_t i = 0; i < lights; ++i) {
    all[i] = static_cast<std::uint32_t>(i);
    if (request.light_ids().empty()) continue;
    const auto found = find_light(*scene, request.light_ids(static_cast<int>(i)));
    if (!found.ok()) return found.status();
    all[i] = *found;
  }
  return all;
}

std::optional<SampledPowers> PowerWork::sampled(std::uint64_t seed,
                                                std::span<const std::uint32_t> which,
                                                const std::stop_token& stop) const {
  SampledPowerSettings settings;
  settings.seed = seed;
  settings.target = rule->target;
  settings.block_count = rule->samples > 0 ? replicates_of(rule->samples) : kReplicates;
  settings.samples_per_block = rule->samples / settings.block_count;
  const auto run = [&](std::uint32_t each,
                       const std::stop_token& s) -> std::optional<SampledPowers> {
    settings.samples_per_block = each;
    SampledPowers powers = sample_powers(*scene, which, settings, s);
    if (powers.stopped) return std::nullopt;
    return powers;
  };
  if (!rule->time_budget_s) return run(settings.samples_per_block, stop);
  return within_time(*rule->time_budget_s, most_samples / settings.block_count, stop, run).first;
}

absl::Status PowerWork::operator()(const v1::EstimatePowerRequest& request,
                                   const std::stop_token& stop,
                                   v1::EstimatePowerResponse* response) const {
  const auto which = this->which(request);
  if (!which.ok()) return which.status();
  std::optional<SampledPowers> by_rays;
  if (rule) {
    by_rays = sampled(request.seed(), *which, stop);
    if (!by_rays) return absl::CancelledError("stopped");
    set_counts(response->mutable_cost(), by_rays->work);
  }
  const auto luminous = [&](std::size_t i) -> Power {
    const std::uint32_t light = (*which)[i];
    if (by_rays) return {by_rays->lights[i].lumens, 0};
    return request.method() == v1::EstimatePowerRequest::METHOD_APPROXIMATE
               ? light_power_approximate(*scene, light)
               : light_power(*scene, light);
  };
  SpectralValues spectral(*scene, wavelengths_nm);
  PowerTotal total(wavelengths_nm.size());
  for (std::size_t i = 0; i < lights && !stop.stop_requested(); ++i) {
    RadiantPower power = radiant_power(*scene, (*which)[i], luminous(i), spectral);
    if (by_rays) power.sampled = by_rays->lights[i];
    total.add(power);
    if (i < first || i - first >= page) continue;
    v1::LightPower* out = response->add_lights();
    out->set_light_id(scene->lights()[(*which)[i]].id);
    set_power(power, out);
  }
  RadiantPower sum = total.value();
  if (by_rays) sum.sampled = by_rays->total;
  set_power(sum, response->mutable_total());
  if (lights - first > page) response->set_next_page_token(page_token("power", first + page));
  return absl::OkStatus();
}

}  // namespace

Prepared estimate_power(const Context& context, const v1::EstimatePowerRequest& request,
                        v1::EstimatePowerResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  const auto method = request.method();
  if (method != v1::EstimatePowerRequest::METHOD_UNSPECIFIED &&
      method != v1::EstimatePowerRequest::METHOD_EXACT &&
      method != v1::EstimatePowerRequest::METHOD_APPROXIMATE &&
      method != v1::EstimatePowerRequest::METHOD_SAMPLED) {
    return bad_field("method", fmt::format("{}", static_cast<int>(method)),
                     "METHOD_EXACT, METHOD_APPROXIMATE or METHOD_SAMPLED");
  }
  PowerWork work;
  if (method == v1::EstimatePowerRequest::METHOD_SAMPLED) {
    const auto rule = check_stop_rule(context, request.accuracy(), kPowerSamples);
    if (!rule.ok()) return rule.status();
    work.rule = *rule;
  }
  const auto wavelengths = check_wavelengths(request.wavelengths_nm());
  if (!wavelengths.ok()) return wavelengths.status();
  const auto asked = static_cast<std::uint64_t>(request.light_ids_size());
  if (asked > context.limits.max_batch_items) {
    return over_limit("light_ids", asked, context.limits.max_batch_items);
  }
  const auto page_size = check_page_size(request.page_size(), context.limits.max_page_size);
  if (!page_size.ok()) return page_size.status();
  const std::size_t n = asked > 0 ? asked : (*scene)->lights().size();
  const auto start = page_start("power", request.page_token(), n);
  if (!start.ok()) return start.status();
  // Pages are as long as messages allow: one light always fits.
  const std::size_t size = std::min<std::size_t>(
      *page_size, std::max<std::uint64_t>(
                      1, answer_size(request).items_within(context.limits.max_message_bytes)));

  work.scene = *scene;
  work.lights = n;
  work.first = *start;
  work.page = size;
  work.wavelengths_nm = *wavelengths;
  work.most_samples = context.limits.max_samples;
  Task task;
  task.predicted_s =
      static_cast<double>(n) *
      (kPowerSeconds + kWavelengthSeconds * static_cast<double>(wavelengths->size()));
  if (work.rule) {
    const std::uint64_t samples =
        work.rule->target ? 2 * work.rule->target->max_samples : work.rule->samples;
    task.predicted_s += work.rule->time_budget_s.value_or(
        static_cast<double>(n) * static_cast<double>(samples) * kRaySeconds);
  }
  task.cost = response->mutable_cost();
  task.run = [work, &request, response](const std::stop_token& stop) {
    return work(request, stop, response);
  };
  return task;
}

}  // namespace lucerna::rpc
