#include "client/library/batches.h"

#include <algorithm>
#include <cstddef>

#include "client/library/answer_checks.h"
#include "client/library/batch_parts.h"
#include "proto/common/answer_size.h"
#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

/// Limits of one batch.
struct BatchLimits {
  std::uint64_t items, bytes;
};

/// Limits for `items` in total, which would take `bytes` in one message.
absl::StatusOr<BatchLimits> batch_limits(const Client& client, std::uint64_t items,
                                         std::uint64_t bytes, const BatchOptions& options) {
  const bool few = options.max_items > 0 || items <= kItemsAlwaysAllowed;
  BatchLimits limits{few ? kItemsAlwaysAllowed : kGoodBatchItems, kBytesAlwaysAllowed};
  if (!few || bytes > kBytesAlwaysAllowed) {
    LUCERNA_ASSIGN_OR_RETURN(const auto info, client.get_server_info({}, options.call));
    limits.items = std::clamp(info.limits().max_batch_items(), 1U, kGoodBatchItems);
    limits.bytes = info.limits().max_message_bytes();
  }
  if (options.max_items > 0) limits.items = options.max_items;
  return limits;
}

/// Sends a request in batches.  Each item counts as `weight` items, in the server's limit and in
/// `answer`.
template <class Request, class Response>
absl::StatusOr<Response> in_batches(
    const Client& client, const Request& request, std::uint64_t weight, const AnswerSize& answer,
    const BatchOptions& options,
    absl::StatusOr<Response> (Client::*method)(const Request&, const CallOptions&) const) {
  const std::uint64_t items = item_count(request);
  if (items <= 1) return (client.*method)(request, options.call);
  // The longer of request and response counts.  Fields that a request has once also count for each
  // item, so the estimate is never too small.
  const std::uint64_t once = answer.fixed + part(request, 0, 0).ByteSizeLong();
  const std::uint64_t each =
      std::max<std::uint64_t>(weight * answer.per_item, request.ByteSizeLong() / items + 1);
  LUCERNA_ASSIGN_OR_RETURN(const auto limits,
                           batch_limits(client, items * weight, once + items * each, options));
  const std::uint64_t by_bytes = limits.bytes > once ? (limits.bytes - once) / each : 0;
  const std::uint64_t size = std::max<std::uint64_t>(1, std::min(limits.items / weight, by_bytes));
  if (items <= size) return (client.*method)(request, options.call);

  Response whole;
  for (std::uint64_t first = 0; first < items; first += size) {
    LUCERNA_ASSIGN_OR_RETURN(
        const auto next,
        (client.*method)(part(request, first, std::min(size, items - first)), options.call));
    append(next, &whole);
  }
  // A batch without an array that the others have leaves a gap.
  LUCERNA_RETURN_IF_ERROR(check_answer(request, whole));
  return whole;
}

}  // namespace

namespace {

/// Sends receivers in batches, for at most `most` samples of each receiver.
absl::StatusOr<v1::SampleLiResponse> sample_li_to_a_target(const Client& client,
                                                           const v1::SampleLiRequest& request,
                                                           const BatchOptions& options) {
  const std::uint64_t most = request.accuracy().target_error().max_samples();
  // The fields of each receiver are counted with its samples.
  AnswerSize size = answer_size(part(request, 0, 0));
  const std::uint64_t receiver = answer_size(part(request, 0, 1)).fixed - size.fixed;
  size.per_item += (receiver + most - 1) / std::max<std::uint64_t>(1, most);
  return in_batches(client, request, std::max<std::uint64_t>(1, most), size, options,
                    &Client::sample_li);
}

}  // namespace

absl::StatusOr<v1::SampleLiResponse> sample_li_in_batches(const Client& client,
                                                          const v1::SampleLiRequest& request,
                                                          const BatchOptions& options) {
  // A time budget holds for one request.
  if (request.accuracy().has_time_budget_s()) return client.sample_li(request, options.call);
  if (!request.accuracy().has_target_error() || item_count(request) <= 1) {
    return in_batches(client, request, std::max(1U, request.accuracy().samples()),
                      answer_size(request), options, &Client::sample_li);
  }
  if (request.accuracy().target_error().has_max_samples())
    return sample_li_to_a_target(client, request, options);
  // Otherwise the number of samples of a receiver would depend on the number of receivers in its
  // request.
  LUCERNA_ASSIGN_OR_RETURN(const auto info, client.get_server_info({}, options.call));
  v1::SampleLiRequest limited = request;
  v1::TargetError* target = limited.mutable_accuracy()->mutable_target_error();
  target->set_max_samples(static_cast<std::uint32_t>(std::min<std::uint64_t>(
      {std::uint64_t{kTargetSamples}, info.limits().max_batch_items(), info.limits().max_samples(),
       answer_size(part(request, 0, 1)).items_within(info.limits().max_message_bytes())})));
  return sample_li_to_a_target(client, limited, options);
}

absl::StatusOr<v1::PdfLiResponse> pdf_li_in_batches(const Client& client,
                                                    const v1::PdfLiRequest& request,
                                                    const BatchOptions& options) {
  return in_batches(client, request, 1, answer_size(request), options, &Client::pdf_li);
}

absl::StatusOr<v1::SampleLeResponse> sample_le_in_batches(const Client& client,
                                                          const v1::SampleLeRequest& request,
                                                          const BatchOptions& options) {
  return in_batches(client, request, 1, answer_size(request), options, &Client::sample_le);
}

absl::StatusOr<v1::PdfLeResponse> pdf_le_in_batches(const Client& client,
                                                    const v1::PdfLeRequest& request,
                                                    const BatchOptions& options) {
  return in_batches(client, request, 1, answer_size(request), options, &Client::pdf_le);
}

absl::StatusOr<v1::LeResponse> le_in_batches(const Client& client, const v1::LeRequest& request,
                                             const BatchOptions& options) {
  return in_batches(client, request, 1, answer_size(request), options, &Client::le);
}

absl::StatusOr<v1::TestVisibilityResponse> test_visibility_in_batches(
    const Client& client, const v1::TestVisibilityRequest& request, const BatchOptions& options) {
  return in_batches(client, request, 1, answer_size(request, true), options,
                    &Client::test_visibility);
}

absl::StatusOr<v1::EstimateIrradianceResponse> estimate_irradiance_in_batches(
    const Client& client, const v1::EstimateIrradianceRequest& request,
    const BatchOptions& options) {
  // A time budget holds for one request; several requests would give each other numbers of samples.
  if (request.accuracy().has_time_budget_s())
    return client.estimate_irradiance(request, options.call);
  // Each item has a share per light, so the answer grows with the number of lights.
  std::uint64_t lights = 0;
  if (request.per_light() && item_count(request) > 1) {
    v1::GetSceneRequest which;
    which.set_scene_id(request.scene_id());
    LUCERNA_ASSIGN_OR_RETURN(const auto scene, client.get_scene(which, options.call));
    lights = scene.summary().lights();
  }
  return in_batches(client, request, 1, answer_size(request, lights), options,
                    &Client::estimate_irradiance);
}

}  // namespace lucerna::client
