#include "client/batches.h"

#include <algorithm>
#include <cstddef>

#include "client/batch_parts.h"

namespace lucerna::client {
namespace {

absl::StatusOr<std::size_t> batch_items(const Client& client, std::size_t items,
                                        const BatchOptions& options) {
  if (options.max_items > 0) return options.max_items;
  if (items <= kItemsNotAskedFor) return kItemsNotAskedFor;
  const auto info = client.get_server_info({}, options.call);
  if (!info.ok()) return info.status();
  return std::clamp(info->limits().max_batch_items(), 1U, kGoodBatchItems);
}

/// `weight`: how many items of the server's limit each item counts for.
template <class Request, class Response>
absl::StatusOr<Response> in_batches(
    const Client& client, const Request& request, std::size_t weight, const BatchOptions& options,
    absl::StatusOr<Response> (Client::*ask)(const Request&, const CallOptions&) const) {
  const std::size_t items = item_count(request);
  const auto limit = batch_items(client, items * weight, options);
  if (!limit.ok()) return limit.status();
  const std::size_t size = std::max<std::size_t>(1, *limit / weight);
  if (items <= size) return (client.*ask)(request, options.call);

  Response whole;
  for (std::size_t first = 0; first < items; first += size) {
    const auto next =
        (client.*ask)(part(request, first, std::min(size, items - first)), options.call);
    if (!next.ok()) return next.status();
    append(*next, &whole);
  }
  return whole;
}

}  // namespace

absl::StatusOr<v1::SampleLiResponse> sample_li_in_batches(const Client& client,
                                                          const v1::SampleLiRequest& request,
                                                          const BatchOptions& options) {
  return in_batches(client, request, std::max(1U, request.accuracy().samples()), options,
                    &Client::sample_li);
}

absl::StatusOr<v1::PdfLiResponse> pdf_li_in_batches(const Client& client,
                                                    const v1::PdfLiRequest& request,
                                                    const BatchOptions& options) {
  return in_batches(client, request, 1, options, &Client::pdf_li);
}

absl::StatusOr<v1::SampleLeResponse> sample_le_in_batches(const Client& client,
                                                          const v1::SampleLeRequest& request,
                                                          const BatchOptions& options) {
  return in_batches(client, request, 1, options, &Client::sample_le);
}

absl::StatusOr<v1::PdfLeResponse> pdf_le_in_batches(const Client& client,
                                                    const v1::PdfLeRequest& request,
                                                    const BatchOptions& options) {
  return in_batches(client, request, 1, options, &Client::pdf_le);
}

absl::StatusOr<v1::LeResponse> le_in_batches(const Client& client, const v1::LeRequest& request,
                                             const BatchOptions& options) {
  return in_batches(client, request, 1, options, &Client::le);
}

absl::StatusOr<v1::TestVisibilityResponse> test_visibility_in_batches(
    const Client& client, const v1::TestVisibilityRequest& request, const BatchOptions& options) {
  return in_batches(client, request, 1, options, &Client::test_visibility);
}

absl::StatusOr<v1::EstimateIrradianceResponse> estimate_irradiance_in_batches(
    const Client& client, const v1::EstimateIrradianceRequest& request,
    const BatchOptions& options) {
  return in_batches(client, request, 1, options, &Client::estimate_irradiance);
}

}  // namespace lucerna::client
