#include "server/rpc/handlers/estimate_power_handler.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/estimate/sample_sum.h"
#include "server/estimate/spectral_values.h"
#include "server/queries/queries.h"
#include "server/queries/sampled_power.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/paging.h"
#include "server/rpc/messages/requested_accuracy.h"
#include "server/runtime/time_budget.h"

namespace lucerna::rpc {
namespace {

constexpr std::uint32_t kPowerSamples = 4096;  // of METHOD_SAMPLED

/// Luminous power, and radiant power if the light has a spectrum.
struct RadiantPower {
  Power luminous;
  std::optional<SampledPower> sampled{};
  std::optional<double> watts{};
  std::vector<double> w_per_nm{};  // at each requested wavelength
  std::string unit{};              // of the luminous power; empty: lm
};

/// The power of one light.  Always finite: a flux in the range of floats times at most
/// kMostWattsPerLumen.
RadiantPower radiant_power(const Scene& scene, std::uint32_t light, const Power& luminous,
                           SpectralValues& spectral) {
  RadiantPower power{.luminous = luminous,
                     .w_per_nm = std::vector<double>(spectral.size()),
                     .unit = power_unit(scene, light)};
  if (const Spectrum* spectrum = scene.lights().spectrum(light)) {
    power.watts = luminance(luminous.lumens) * spectrum->watts_per_lumen();
  }
  spectral.add(light, luminous.lumens, power.w_per_nm);
  return power;
}

/// The sum over lights of any magnitude.  Small values are not lost beside large ones.
class PowerTotal {
 public:
  explicit PowerTotal(std::size_t wavelengths) : w_per_nm_(wavelengths) {}

  void add(const RadiantPower& power) {
    if (is_empty_) unit_ = power.unit;
    if (power.unit != unit_) unit_ = "mixed";
    is_empty_ = false;
    lumens_.add(power.luminous.lumens);
    error_lumens_.add(power.luminous.error_lumens);
    has_watts_ = has_watts_ && power.watts;
    watts_.add(power.watts.value_or(0));
    for (std::size_t k = 0; k < w_per_nm_.size(); ++k) w_per_nm_[k].add(power.w_per_nm[k]);
  }
  /// It has watts if all added powers have.
  RadiantPower value() const {
    RadiantPower sum{.luminous = {lumens_.value(), error_lumens_.value()}};
    if (has_watts_ && !is_empty_) sum.watts = watts_.value();
    for (const CompensatedSum& at : w_per_nm_) sum.w_per_nm.push_back(at.value());
    sum.unit = unit_;
    return sum;
  }

 private:
  SampleSum lumens_;
  CompensatedSum error_lumens_, watts_;
  bool has_watts_ = true, is_empty_ = true;
  std::vector<CompensatedSum> w_per_nm_;
  std::string unit_;
};

/// Instead of infinity.  Squares of extreme fluxes may overflow; the bound is still valid.
constexpr double kLargest = std::numeric_limits<double>::max();

void set_power(const RadiantPower& radiant, v1::LightPower* out) {
  const Power& power = radiant.luminous;
  if (radiant.sampled) {
    const SampledPower& sampled = *radiant.sampled;
    // A single sample has no standard error and no interval.
    if (std::isfinite(sampled.interval_lm.upper) || std::isfinite(sampled.standard_error_lm)) {
      out->set_standard_error_lm(std::min(kLargest, sampled.standard_error_lm));
      out->set_lower_lm(
          sampled.interval_lm.lower > 0 ? std::min(kLargest, sampled.interval_lm.lower) : 0);
      out->set_upper_lm(std::min(kLargest, sampled.interval_lm.upper));
    }
    out->set_samples(sampled.samples);
  }
  set(power.lumens, out->mutable_rgb_lm());
  out->set_power_lm(luminance(power.lumens));
  out->set_error_lm(power.error_lumens);
  if (radiant.watts) out->set_power_w(*radiant.watts);
  out->set_power_unit(radiant.unit);
  out->mutable_spectral_w_per_nm()->Add(radiant.w_per_nm.begin(), radiant.w_per_nm.end());
}

struct PowerQuery {
  std::shared_ptr<const Scene> scene;
  v1::EstimatePowerRequest::Method method{};
  std::size_t lights = 0;           // of the request, or of the scene
  std::size_t first = 0, page = 0;  // of these lights, in the answer
  std::span<const double> wavelengths_nm{};
  std::optional<StopRule> rule{};  // of METHOD_SAMPLED
  std::uint32_t most_samples = 0;  // with a time budget
};

/// The list that the request asks for, for page tokens.
std::string power_list(const Scene& scene, v1::EstimatePowerRequest request) {
  request.set_scene_id(scene.id());
  request.clear_page_size();
  request.clear_page_token();
  return "power " + request.SerializeAsString();
}

absl::StatusOr<PowerQuery> parse(const CallContext& context,
                                 const v1::EstimatePowerRequest& request) {
  PowerQuery query;
  LUCERNA_ASSIGN_OR_RETURN(query.scene, find_scene(context, request.scene_id()));
  query.method = request.method();
  if (query.method < v1::EstimatePowerRequest::METHOD_UNSPECIFIED ||
      query.method > v1::EstimatePowerRequest::METHOD_SAMPLED) {
    return bad_field("method", static_cast<int>(query.method),
                     "METHOD_EXACT, METHOD_APPROXIMATE or METHOD_SAMPLED");
  }
  if (query.method == v1::EstimatePowerRequest::METHOD_SAMPLED) {
    LUCERNA_ASSIGN_OR_RETURN(query.rule,
                             check_stop_rule(context, request.accuracy(), kPowerSamples));
  }
  LUCERNA_ASSIGN_OR_RETURN(query.wavelengths_nm, check_wavelengths(request.wavelengths_nm()));
  const auto named = static_cast<std::uint64_t>(request.light_ids_size()) +
                     static_cast<std::uint64_t>(request.light_names_size());
  LUCERNA_RETURN_IF_ERROR(
      check_limit("light_ids and light_names", named, context.limits.max_batch_items));
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t page_size,
                           check_page_size(request.page_size(), context.limits.max_page_size));
  query.lights = named > 0 ? named : query.scene->lights().size();
  if (!request.page_token().empty()) {
    LUCERNA_ASSIGN_OR_RETURN(query.first, page_start(power_list(*query.scene, request),
                                                     request.page_token(), query.lights));
  }
  // The message size may end a page early, but one light always fits.
  const std::uint64_t fits = answer_size(request).items_within(context.limits.max_message_bytes);
  query.page = std::min<std::size_t>(page_size, std::max<std::uint64_t>(1, fits));
  query.most_samples = context.limits.max_samples;
  return query;
}

double predicted_seconds(const PowerQuery& query) {
  constexpr double kPowerSeconds = 300e-9, kPowerRaySeconds = 300e-9;
  const double seconds = seconds_of(query.lights, kPowerSeconds, query.wavelengths_nm.size());
  if (!query.rule) return seconds;
  if (query.rule->time_budget_s) return seconds + *query.rule->time_budget_s;
  // With a target error, pilots may take as many samples as the answer.
  const std::uint64_t samples =
      query.rule->target ? 2 * query.rule->target->max_samples : query.rule->samples;
  return seconds + seconds_of(query.lights, static_cast<double>(samples) * kPowerRaySeconds);
}

/// Indices of the lights that the request names, or of all lights.
absl::StatusOr<std::vector<std::uint32_t>> requested_lights(
    const PowerQuery& query, const v1::EstimatePowerRequest& request) {
  std::vector<std::uint32_t> all(query.lights);
  std::iota(all.begin(), all.end(), 0U);
  for (int i = 0; i < request.light_ids_size(); ++i) {
    LUCERNA_ASSIGN_OR_RETURN(all[static_cast<std::size_t>(i)],
                             find_light(*query.scene, request.light_ids(i)));
  }
  const auto ids = static_cast<std::size_t>(request.light_ids_size());
  for (int i = 0; i < request.light_names_size(); ++i) {
    LUCERNA_ASSIGN_OR_RETURN(
        all[ids + static_cast<std::size_t>(i)],
        find_named_light(*query.scene, request.light_names(i), fmt::format("light_names[{}]", i)));
  }
  return all;
}

/// METHOD_SAMPLED: the mean over rays.  Nothing if `stop` was requested.
std::optional<SampledPowers> sampled_powers(const PowerQuery& query, std::uint64_t seed,
                                            std::span<const std::uint32_t> lights,
                                            const std::stop_token& stop) {
  const StopRule& rule = *query.rule;
  SampledPowerSettings settings;
  settings.seed = seed;
  settings.target = rule.target;
  settings.block_count = rule.samples > 0 ? blocks_of(rule.samples) : kDefaultBlocks;
  const auto run = [&](std::uint32_t each,
                       const std::stop_token& s) -> std::optional<SampledPowers> {
    settings.samples_per_block = each;
    SampledPowers powers = sample_powers(*query.scene, lights, settings, s);
    if (powers.stopped) return std::nullopt;
    return powers;
  };
  if (!rule.time_budget_s) return run(rule.samples / settings.block_count, stop);
  return within_time(*rule.time_budget_s, query.most_samples / settings.block_count, stop, run)
      .first;
}

absl::Status answer(const PowerQuery& query, const v1::EstimatePowerRequest& request,
                    const std::stop_token& stop, v1::EstimatePowerResponse* response) {
  const Scene& scene = *query.scene;
  LUCERNA_ASSIGN_OR_RETURN(const std::vector<std::uint32_t> lights,
                           requested_lights(query, request));
  std::optional<SampledPowers> by_rays;
  if (query.rule) {
    by_rays = sampled_powers(query, request.seed(), lights, stop);
    if (!by_rays) return absl::CancelledError("stopped");
    set_counts(response->mutable_cost(), by_rays->work);
  }
  const auto luminous = [&](std::size_t i) -> Power {
    if (by_rays) return {by_rays->lights[i].lumens, 0};
    return query.method == v1::EstimatePowerRequest::METHOD_APPROXIMATE
               ? light_power_approximate(scene, lights[i])
               : light_power(scene, lights[i]);
  };
  SpectralValues spectral(scene, query.wavelengths_nm);
  PowerTotal total(query.wavelengths_nm.size());
  for (std::size_t i = 0; i < query.lights && !stop.stop_requested(); ++i) {
    RadiantPower power = radiant_power(scene, lights[i], luminous(i), spectral);
    if (by_rays) power.sampled = by_rays->lights[i];
    total.add(power);
    if (i < query.first || i - query.first >= query.page) continue;
    v1::LightPower* out = response->add_lights();
    out->set_light_id(scene.lights()[lights[i]].id);
    set_power(power, out);
  }
  RadiantPower sum = total.value();
  if (by_rays) sum.sampled = by_rays->total;
  set_power(sum, response->mutable_total());
  if (query.lights - query.first > query.page)
    response->set_next_page_token(
        page_token(power_list(*query.scene, request), query.first + query.page));
  return absl::OkStatus();
}

}  // namespace

Prepared handle_estimate_power(const CallContext& context, const v1::EstimatePowerRequest& request,
                               v1::EstimatePowerResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const PowerQuery query, parse(context, request));
  // All lights are computed, for the total.
  return batch_task(predicted_seconds(query), query.lights, response,
                    [query, &request, response](const std::stop_token& stop) {
                      return answer(query, request, stop, response);
                    });
}

}  // namespace lucerna::rpc
