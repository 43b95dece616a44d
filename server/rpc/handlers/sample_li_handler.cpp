#include "server/rpc/handlers/sample_li_handler.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/queries/li_estimates.h"
#include "server/queries/queries.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/estimate_arrays.h"
#include "server/rpc/messages/randomness.h"
#include "server/rpc/messages/requested_accuracy.h"
#include "server/runtime/denormals.h"
#include "server/runtime/time_budget.h"

namespace lucerna::rpc {
namespace {

// Pilots take at most a third of the needed samples.
constexpr double kWithPilots = 4.0 / 3;

/// A request of SampleLi.
struct LiRequest {
  std::shared_ptr<const Scene> scene;
  SampleLiQuery query;
  StopRule stop_rule;
  std::uint32_t most_samples = 0;  ///< of each receiver, if estimated

  /// A target error or a time budget sets the sample count, and the answer has estimates.
  bool is_estimated() const { return stop_rule.samples == 0; }
  std::uint64_t samples() const { return std::uint64_t{query.samples} * query.receivers.size(); }
};

SampleLiAnswer sized_arrays(const Scene& scene, const SampleLiQuery& query, std::size_t n,
                            v1::SampleLiResponse* r) {
  const bool chosen = !query.light;
  const bool is_partial =
      query.test_visibility && Transmittance(scene, query.methods.thin_glass).is_partial();
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
          .spectral_value = fill(r->mutable_spectral_value(), n * query.wavelengths_nm.size()),
          .transmittance = is_partial ? fill(r->mutable_transmittance(), 3 * n) : nullptr};
}

void put_estimates(const LiLayout& layout, const LiEstimates& estimates, std::size_t wavelengths,
                   v1::ReceiverEstimates* to) {
  const std::size_t receivers = estimates.points.size();
  std::uint32_t* const samples = fill(to->mutable_samples(), receivers);
  int* const status = fill(to->mutable_status(), receivers);
  const EstimateArrays arrays = estimate_arrays(receivers, true, to);
  const SpectralArrays spectra{
      wavelengths, fill(to->mutable_spectral_irradiance(), receivers * wavelengths),
      fill(to->mutable_spectral_standard_error(), receivers * wavelengths)};
  for (std::size_t r = 0; r < receivers; ++r) {
    samples[r] = static_cast<std::uint32_t>(layout.begin(r + 1) - layout.begin(r));
    status[r] = static_cast<int>(estimates.results[r]);
    if (arrays.put(r, estimates.points[r]) &&
        spectra.put(r, estimates.spectral, estimates.spectral_error, r))
      continue;
    arrays.clear(r);
    spectra.clear(r);
    status[r] = static_cast<int>(ItemResult::kOutOfRange);
  }
  drop_if_all_ok(to->mutable_status());
}

/// Samples and their estimates.  `work`: that of the pilots.  Nothing if `stop` was requested.
std::optional<v1::SampleLiResponse> estimate(const LiRequest& li, const LiSampler& sampler,
                                             std::span<const std::uint32_t> samples_per_block,
                                             WorkCounts work, const std::stop_token& stop) {
  const DenormalsAreZero denormals;
  const SampleLiQuery& query = li.query;
  const std::size_t wavelengths = query.wavelengths_nm.size();
  const LiLayout layout(samples_per_block, kDefaultBlocks);
  std::optional<v1::SampleLiResponse> response(std::in_place);
  const SampleLiAnswer answer = sized_arrays(*li.scene, query, layout.size(), &*response);
  std::vector<LiShare> shares(layout.size());
  work += fill_samples(sampler, layout, answer, shares, stop);
  if (stop.stop_requested()) return std::nullopt;
  const double confidence = li.stop_rule.target.value_or(TargetError{}).confidence;
  const LiEstimates estimates =
      estimates_of(sampler, layout, query.receivers.size(), kDefaultBlocks, confidence, shares,
                   {answer.status, layout.size()},
                   {answer.spectral_value, layout.size() * wavelengths}, wavelengths);
  put_estimates(layout, estimates, wavelengths, response->mutable_estimates());
  static_cast<void>(finish_batch(&*response, work));
  return response;
}

/// Answers with as many samples as the target error or the time budget sets.
absl::Status answer_estimated(const LiRequest& li, const std::stop_token& stop,
                              v1::SampleLiResponse* response) {
  const LiSampler sampler(*li.scene, li.query);
  const std::size_t receivers = li.query.receivers.size();
  std::optional<v1::SampleLiResponse> best;
  if (li.stop_rule.target) {
    WorkCounts pilots;
    const auto needed =
        samples_needed(sampler, receivers, *li.stop_rule.target, kDefaultBlocks, stop, pilots);
    if (needed) best = estimate(li, sampler, *needed, pilots, stop);
  } else {
    const std::uint32_t most = sampler.needs_one_sample() ? 1 : li.most_samples / kDefaultBlocks;
    best = within_time(*li.stop_rule.time_budget_s, most, stop,
                       [&](std::uint32_t each, const std::stop_token& in_time) {
                         return estimate(li, sampler, equally_many(sampler, receivers, each), {},
                                         in_time);
                       })
               .first;
  }
  if (!best) return absl::CancelledError("stopped");
  // Not swapped: the caller has a pointer to the response's cost, where it writes the times.
  response->MergeFrom(*best);
  return absl::OkStatus();
}

absl::Status answer_plain(const LiRequest& li, const v1::SampleLiRequest& request,
                          const std::stop_token& stop, v1::SampleLiResponse* response) {
  LUCERNA_RETURN_IF_ERROR(check_u(request.u()));
  const SampleLiAnswer answer = sized_arrays(*li.scene, li.query, li.samples(), response);
  return finish_batch(response, sample_li(*li.scene, li.query, answer, stop));
}

/// The most samples that each receiver of an estimated request may have.
absl::StatusOr<std::uint32_t> check_most_samples(const CallContext& context,
                                                 const v1::SampleLiRequest& request,
                                                 const LiRequest& li) {
  const AnswerSize size = answer_size(request);
  const std::uint64_t at_once = std::min<std::uint64_t>(
      context.limits.max_batch_items, size.items_within(context.limits.max_message_bytes));
  const std::uint64_t receivers = li.query.receivers.size();
  const bool certain = one_sample_is_enough(*li.scene, li.query.light);
  const auto over = [&](const std::string& field, std::uint64_t each) {
    return over_limit(fmt::format("receivers times {} ({} bytes for each sample in the answer)",
                                  field, size.per_item),
                      receivers * each, at_once);
  };
  const auto& target = li.stop_rule.target;
  if (!certain && request.accuracy().target_error().has_max_samples()) {
    if (receivers * target->max_samples > at_once)
      return over("accuracy.target_error.max_samples", target->max_samples);
    return static_cast<std::uint32_t>(target->max_samples);
  }
  const std::uint32_t least = certain ? 1 : target ? kLeastTargetSamples : kDefaultBlocks;
  if (receivers * least > at_once)
    return over(fmt::format("{} samples, the least number for each", least), least);
  const std::uint64_t most = target ? target->max_samples : context.limits.max_samples;
  return static_cast<std::uint32_t>(receivers > 0 ? std::min(most, at_once / receivers) : most);
}

absl::Status parse_sample_values(const v1::SampleLiRequest& request, LiRequest& li) {
  if (li.is_estimated() && request.has_u()) {
    return bad_field(
        "u", "given",
        "seed, since accuracy.target_error and accuracy.time_budget_s set the number of "
        "samples");
  }
  return put_randomness(request,
                        {.samples = li.samples(),
                         .per_sample = 2,
                         .light_named = names_light(request),
                         .of = "samples"},
                        li.query);
}

absl::StatusOr<LiRequest> parse(const CallContext& context, const v1::SampleLiRequest& request) {
  constexpr char kItems[] = "receivers times accuracy.samples";
  LiRequest li;
  SampleLiQuery& query = li.query;
  LUCERNA_ASSIGN_OR_RETURN(li.scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(query.receivers,
                           check_points(context, "receivers", request.receivers()));
  LUCERNA_ASSIGN_OR_RETURN(li.stop_rule, check_stop_rule(context, request.accuracy(), 1));
  query.samples = li.stop_rule.samples;
  // An estimated request has no count yet; check_most_samples checks its limits.
  LUCERNA_RETURN_IF_ERROR(check_limit(kItems, li.samples(), context.limits.max_batch_items));
  LUCERNA_ASSIGN_OR_RETURN(query.light, find_light_if_named(*li.scene, request));
  LUCERNA_RETURN_IF_ERROR(parse_sample_values(request, li));
  LUCERNA_ASSIGN_OR_RETURN(query.time_s, check_time(request.time_s()));
  LUCERNA_ASSIGN_OR_RETURN(query.wavelengths_nm, check_wavelengths(request.wavelengths_nm()));
  if (!li.is_estimated()) {
    LUCERNA_RETURN_IF_ERROR(check_answer_size(context, kItems, li.samples(), answer_size(request)));
  }
  query.test_visibility = request.test_visibility();
  if (query.test_visibility)
    LUCERNA_RETURN_IF_ERROR(check_grey_media(*li.scene, query.wavelengths_nm));
  LUCERNA_ASSIGN_OR_RETURN(query.normals, check_triples("normals", request.normals(),
                                                        query.receivers.size(), "receivers", true));
  LUCERNA_ASSIGN_OR_RETURN(
      query.position_error_m,
      check_position_error(request.has_position_error_m(), request.position_error_m()));
  LUCERNA_ASSIGN_OR_RETURN(query.methods, check_methods(request.accuracy()));
  if (li.is_estimated()) {
    LUCERNA_ASSIGN_OR_RETURN(li.most_samples, check_most_samples(context, request, li));
    if (li.stop_rule.target) li.stop_rule.target->max_samples = li.most_samples;
  }
  return li;
}

double predicted_seconds(const LiRequest& li) {
  constexpr double kLightSampleSeconds = 400e-9, kShadowRaySeconds = 1e-6;
  const double of_sample =
      seconds_of(1, kLightSampleSeconds + (li.query.test_visibility ? kShadowRaySeconds : 0),
                 li.query.wavelengths_nm.size());
  const auto receivers = static_cast<double>(li.query.receivers.size());
  double seconds = li.query.test_visibility ? first_use_seconds(*li.scene, li.query.methods) : 0;
  if (li.stop_rule.target) {
    seconds += kWithPilots * li.most_samples * receivers * of_sample;
  } else if (li.stop_rule.time_budget_s) {
    // The least number of samples is always taken.
    seconds += std::max(*li.stop_rule.time_budget_s, kDefaultBlocks * receivers * of_sample);
  } else {
    seconds += static_cast<double>(li.samples()) * of_sample;
  }
  return seconds;
}

}  // namespace

Prepared handle_sample_li(const CallContext& context, const v1::SampleLiRequest& request,
                          v1::SampleLiResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const LiRequest li, parse(context, request));
  return batch_task(predicted_seconds(li), li.query.receivers.size(), response,
                    [li, &request, response](const std::stop_token& stop) {
                      return li.is_estimated() ? answer_estimated(li, stop, response)
                                               : answer_plain(li, request, stop, response);
                    });
}

}  // namespace lucerna::rpc
