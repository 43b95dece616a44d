// SampleLi and PdfLi.
#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "server/estimate/queries/li_estimates.h"
#include "server/estimate/queries/queries.h"
#include "server/estimate/queries/spectral_values.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/estimate_arrays.h"
#include "server/rpc/messages/randomness.h"
#include "server/rpc/messages/requested_methods.h"
#include "server/rpc/messages/stop_rule.h"
#include "server/runtime/denormals.h"
#include "server/runtime/time_budget.h"

namespace lucerna::rpc {
namespace {

// Processor time of one item [s], rounded up from what one core took on the reference scenes.
constexpr double kLightSampleSeconds = 400e-9;
constexpr double kShadowRaySeconds = 1e-6;

// Pilots take a third of the samples that they find to be needed, at most.
constexpr double kWithPilots = 4.0 / 3;

SampleLiAnswer make_room(const SampleLiQuery& query, std::size_t n, v1::SampleLiResponse* r) {
  const bool chosen = !query.light;
  return {.value = fill(r->mutable_value(), 3 * n),
          .wi = fill(r->mutable_wi(), 3 * n),
          .distance_m = fill(r->mutable_distance_m(), n),
          .light_offsets_m = fill(r->mutable_light_offsets_m(), 3 * n),
          .light_normals = fill(r->mutable_light_normals(), 3 * n),
          .pdf_per_sr = fill(r->mutable_pdf_per_sr(), n),
          .delta = fill_bits(r->mutable_delta(), n),
          .visible = query.test_visibility ? fill_bits(r->mutable_visible(), n) : nullptr,
          .light_ids = chosen ? fill(r->mutable_light_ids(), n) : nullptr,
          .selection_probability = chosen ? fill(r->mutable_selection_probability(), n) : nullptr,
          .status = fill(r->mutable_status(), n),
          .spectral_value = fill(r->mutable_spectral_value(), n * query.wavelengths_nm.size())};
}

/// As many samples as an error or a time asks for, and what they say.
struct EstimatedSamples {
  std::shared_ptr<const Scene> scene;
  SampleLiQuery query;
  StopRule stop_rule;
  std::uint32_t most_samples = 0;  ///< of each receiver

  absl::Status operator()(const std::stop_token& stop, v1::SampleLiResponse* response) const;

 private:
  /// Nothing where it was stopped.
  std::optional<v1::SampleLiResponse> answer(const LiSampler& sampler,
                                             std::span<const std::uint32_t> samples_per_replicate,
                                             WorkCounts work, const std::stop_token& stop) const;
};

absl::Status EstimatedSamples::operator()(const std::stop_token& stop,
                                          v1::SampleLiResponse* response) const {
  const LiSampler sampler(*scene, query);
  const std::size_t receivers = query.receivers.size();
  std::optional<v1::SampleLiResponse> best;
  if (stop_rule.target) {
    WorkCounts pilots;
    const auto needed =
        samples_needed(sampler, receivers, *stop_rule.target, kReplicates, stop, pilots);
    if (needed) best = answer(sampler, *needed, pilots, stop);
  } else {
    best =
        within_time(*stop_rule.time_budget_s,
                    sampler.says_all_at_once() ? 1 : most_samples / kReplicates, stop,
                    [&](std::uint32_t each, const std::stop_token& in_time) {
                      return answer(sampler, equally_many(sampler, receivers, each), {}, in_time);
                    })
            .first;
  }
  if (!best) return absl::CancelledError("stopped");
  // Not swapped: the times of the work are put where the cost is now.
  response->MergeFrom(*best);
  return absl::OkStatus();
}

std::optional<v1::SampleLiResponse> EstimatedSamples::answer(
    const LiSampler& sampler, std::span<const std::uint32_t> samples_per_replicate, WorkCounts work,
    const std::stop_token& stop) const {
  const DenormalsAreZero denormals;
  const std::size_t receivers = samples_per_replicate.size();
  const std::size_t wavelengths = query.wavelengths_nm.size();
  const LiLayout layout(samples_per_replicate, kReplicates);
  std::optional<v1::SampleLiResponse> response(std::in_place);
  const SampleLiAnswer room = make_room(query, layout.size(), &*response);
  std::vector<LiShare> shares(layout.size());
  work += fill_samples(sampler, layout, room, shares, stop);
  if (stop.stop_requested()) return std::nullopt;
  const LiEstimates estimates = estimates_of(
      layout, receivers, kReplicates, stop_rule.target.value_or(TargetError{}).confidence, shares,
      {room.status, layout.size()}, {room.spectral_value, layout.size() * wavelengths},
      wavelengths);

  v1::ReceiverEstimates* to = response->mutable_estimates();
  std::uint32_t* const samples = fill(to->mutable_samples(), receivers);
  int* const status = fill(to->mutable_status(), receivers);
  const EstimateArrays arrays{.rgb = nullptr,
                              .illuminance = fill(to->mutable_illuminance_lx(), receivers),
                              .standard_error = fill(to->mutable_standard_error_lx(), receivers),
                              .lower = fill(to->mutable_lower_lx(), receivers),
                              .upper = fill(to->mutable_upper_lx(), receivers),
                              .zero_bound = nullptr};
  float* const spectral = fill(to->mutable_spectral_irradiance(), receivers * wavelengths);
  float* const spectral_error =
      fill(to->mutable_spectral_standard_error(), receivers * wavelengths);
  for (std::size_t r = 0; r < receivers; ++r) {
    samples[r] = static_cast<std::uint32_t>(layout.begin(r + 1) - layout.begin(r));
    status[r] = static_cast<int>(estimates.results[r]);
    const auto at_wavelengths = [&](const std::vector<double>& values, float* array) {
      return store_spectral({values.data() + r * wavelengths, wavelengths},
                            array + r * wavelengths);
    };
    if (arrays.put(r, estimates.points[r]) && at_wavelengths(estimates.spectral, spectral) &&
        at_wavelengths(estimates.spectral_error, spectral_error)) {
      continue;
    }
    arrays.clear(r);
    for (float* const array : {spectral, spectral_error})
      std::fill_n(array + r * wavelengths, wavelengths, 0.0F);
    status[r] = static_cast<int>(ItemResult::kOutOfRange);
  }
  drop_if_all_ok(to->mutable_status());
  drop_if_all_ok(response->mutable_status());
  set_counts(response->mutable_cost(), work);
  return response;
}

/// The most samples that each receiver may have, where estimates are asked for.
absl::StatusOr<std::uint32_t> check_most_samples(const Context& context,
                                                 const v1::SampleLiRequest& request,
                                                 const EstimatedSamples& asked) {
  const AnswerSize size = answer_size(request);
  const std::uint64_t at_once = std::min<std::uint64_t>(
      context.limits.max_batch_items, size.items_within(context.limits.max_message_bytes));
  const std::uint64_t receivers = asked.query.receivers.size();
  const bool certain = one_sample_says_all(*asked.scene, asked.query.light);
  const auto over = [&](const std::string& field, std::uint64_t each) {
    return over_limit(
        fmt::format("receivers times {}, each sample answered in {} bytes,", field, size.per_item),
        receivers * each, at_once);
  };
  const auto& target = asked.stop_rule.target;
  if (!certain && request.accuracy().target_error().has_max_samples()) {
    if (receivers * target->max_samples > at_once)
      return over("accuracy.target_error.max_samples", target->max_samples);
    return static_cast<std::uint32_t>(target->max_samples);
  }
  const std::uint32_t least = certain ? 1 : target ? kLeastMostSamples : kReplicates;
  if (receivers * least > at_once)
    return over(fmt::format("{} samples, the least that each can have", least), least);
  const std::uint64_t most = target ? target->max_samples : context.limits.max_samples;
  return static_cast<std::uint32_t>(receivers > 0 ? std::min(most, at_once / receivers) : most);
}

}  // namespace

Prepared sample_li(const Context& context, const v1::SampleLiRequest& request,
                   v1::SampleLiResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  SampleLiQuery query;
  const auto receivers = check_points(context, "receivers", request.receivers());
  if (!receivers.ok()) return receivers.status();
  query.receivers = *receivers;
  const auto rule = check_stop_rule(context, request.accuracy(), 1);
  if (!rule.ok()) return rule.status();
  const bool estimated = rule->samples == 0;
  query.samples = rule->samples;
  // Where it is estimated, each receiver has its own count, and the limits are looked at below.
  const std::uint64_t n = std::uint64_t{query.samples} * query.receivers.size();
  if (n > context.limits.max_batch_items) {
    return over_limit("receivers times accuracy.samples", n, context.limits.max_batch_items);
  }
  const auto light = find_light_if_named(**scene, request);
  if (!light.ok()) return light.status();
  query.light = *light;
  if (estimated && request.has_u()) {
    return bad_field("u", "given",
                     "seed, as accuracy.target_error and accuracy.time_budget_s say how many "
                     "samples there are");
  }
  const auto randomness = check_randomness(
      request,
      {.samples = n, .per_sample = 2, .light_named = request.has_light_id(), .of = "samples"});
  if (!randomness.ok()) return randomness.status();
  query.seed = randomness->seed;
  query.u = randomness->u;
  query.u_light = randomness->u_light;
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  const auto wavelengths = check_wavelengths(request.wavelengths_nm());
  if (!wavelengths.ok()) return wavelengths.status();
  query.wavelengths_nm = *wavelengths;
  if (!estimated) {
    if (auto s =
            check_answer_size(context, "receivers times accuracy.samples", n, answer_size(request));
        !s.ok()) {
      return s;
    }
  }
  query.time_s = request.time_s();
  query.test_visibility = request.test_visibility();
  if (auto s =
          check_triples("normals", request.normals(), query.receivers.size(), "receivers", true);
      !s.ok()) {
    return s;
  }
  query.normals = view(request.normals());
  const auto error =
      check_position_error(request.has_position_error_m(), request.position_error_m());
  if (!error.ok()) return error.status();
  query.position_error_m = *error;
  const auto methods = check_methods(request.accuracy());
  if (!methods.ok()) return methods.status();
  query.methods = *methods;

  EstimatedSamples estimates{.scene = *scene, .query = query, .stop_rule = *rule};
  if (estimated) {
    const auto most = check_most_samples(context, request, estimates);
    if (!most.ok()) return most.status();
    estimates.most_samples = *most;
    if (rule->target) estimates.stop_rule.target->max_samples = *most;
  }

  Task task;
  const double sample_s = kLightSampleSeconds + (query.test_visibility ? kShadowRaySeconds : 0) +
                          kWavelengthSeconds * static_cast<double>(query.wavelengths_nm.size());
  const auto receiver_count = static_cast<double>(query.receivers.size());
  if (rule->target)
    task.predicted_s = kWithPilots * estimates.most_samples * receiver_count * sample_s;
  else if (rule->time_budget_s)  // and as many as there are whatever it takes
    task.predicted_s = std::max(*rule->time_budget_s, kReplicates * receiver_count * sample_s);
  else
    task.predicted_s = static_cast<double>(n) * sample_s;
  if (query.test_visibility) task.predicted_s += first_use_seconds(**scene, query.methods);
  task.cost = response->mutable_cost();
  if (estimated) {
    task.run = [estimates, response](const std::stop_token& stop) {
      return estimates(stop, response);
    };
    return task;
  }
  task.run = [scene = *scene, query, n, &request, response](const std::stop_token& stop) {
    if (auto s = check_u(request.u()); !s.ok()) return s;
    const SampleLiAnswer answer = make_room(query, n, response);
    set_counts(response->mutable_cost(), lucerna::sample_li(*scene, query, answer, stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

Prepared pdf_li(const Context& context, const v1::PdfLiRequest& request,
                v1::PdfLiResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  const auto receivers = check_points(context, "receivers", request.receivers());
  if (!receivers.ok()) return receivers.status();
  const std::size_t n = receivers->size();
  if (auto s = check_answer_size(context, "receivers", n, answer_size(request)); !s.ok()) return s;
  if (auto s = check_triples("wi", request.wi(), n, "receivers", false); !s.ok()) return s;
  const auto light = find_required_light(**scene, request.light_id());
  if (!light.ok()) return light.status();
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  if (auto s = check_triples("normals", request.normals(), n, "receivers", true); !s.ok()) return s;
  const auto methods = check_methods(request.accuracy());
  if (!methods.ok()) return methods.status();
  const PdfLiQuery query{.light = *light,
                         .receivers = *receivers,
                         .wi = view(request.wi()),
                         .normals = view(request.normals()),
                         .area_sampling = methods->area_sampling,
                         .time_s = request.time_s()};

  Task task;
  task.predicted_s = static_cast<double>(n) * pdf_seconds((*scene)->lights()[*light].light);
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, n, response](const std::stop_token& stop) {
    lucerna::pdf_li(*scene, query, fill(response->mutable_pdf_per_sr(), n),
                    fill(response->mutable_status(), n), stop);
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
