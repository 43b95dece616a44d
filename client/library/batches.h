// Sends requests of any size in batches that the server accepts.
//
//   v1::EstimateIrradianceRequest request;
//   request.set_scene_id(scene_id);
//   *request.mutable_receivers() = make_points(a_million_points);
//   ...
//   const auto response = estimate_irradiance_in_batches(client, request);
//
// The answer has the bits of a single request, since each batch states its position in the whole
// set (Seed.first_item).  `cost` is the sum over the batches.  Batches are sent one after the
// other.  The first error ends the sequence and is the only result.  A request whose arrays do not
// match each other is sent unchanged, so that the server reports the error.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "lucerna/client/client.h"

namespace lucerna::client {

/// Larger batches are not faster: messages of 32 to 256 KiB are the fastest.
inline constexpr std::uint32_t kGoodBatchItems = 8192;

/// Every server accepts this many items and bytes in a message.  GetServerInfo reports its own
/// limits.
inline constexpr std::uint32_t kItemsAlwaysAllowed = 1024;
inline constexpr std::uint64_t kBytesAlwaysAllowed = 1 << 20;

/// Limits of a batch.  Requests and responses also stay within the server's message limit, unless a
/// single item exceeds it.
struct BatchOptions {
  /// Items of one batch, at least 1.  0: the server's limit, at most kGoodBatchItems.
  std::uint32_t max_items = 0;
  /// The deadline is for all batches together.
  CallOptions call = {};
};

/// SampleLi.  An item here is a sample: a batch holds max_items / samples receivers, and at least
/// one.  With a target error, `max_samples` counts as the number of samples.  If that is unset,
/// each receiver may have as many samples as in a separate request.  With a time budget, there is
/// one request.
absl::StatusOr<v1::SampleLiResponse> sample_li_in_batches(const Client& client,
                                                          const v1::SampleLiRequest& request,
                                                          const BatchOptions& options = {});
absl::StatusOr<v1::PdfLiResponse> pdf_li_in_batches(const Client& client,
                                                    const v1::PdfLiRequest& request,
                                                    const BatchOptions& options = {});
/// SampleLe.  An item here is a ray.
absl::StatusOr<v1::SampleLeResponse> sample_le_in_batches(const Client& client,
                                                          const v1::SampleLeRequest& request,
                                                          const BatchOptions& options = {});
absl::StatusOr<v1::PdfLeResponse> pdf_le_in_batches(const Client& client,
                                                    const v1::PdfLeRequest& request,
                                                    const BatchOptions& options = {});
absl::StatusOr<v1::LeResponse> le_in_batches(const Client& client, const v1::LeRequest& request,
                                             const BatchOptions& options = {});
absl::StatusOr<v1::TestVisibilityResponse> test_visibility_in_batches(
    const Client& client, const v1::TestVisibilityRequest& request,
    const BatchOptions& options = {});
/// EstimateIrradiance.  With `per_light`, this also calls GetScene for the number of lights.  With
/// a time budget, there is one request.
absl::StatusOr<v1::EstimateIrradianceResponse> estimate_irradiance_in_batches(
    const Client& client, const v1::EstimateIrradianceRequest& request,
    const BatchOptions& options = {});

}  // namespace lucerna::client
