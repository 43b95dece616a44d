// Questions about any number of points, asked in batches that the server accepts.
//
// The answer is what one batch would have been answered with, to the bit, since the requests say
// where in the whole set each batch begins (Seed.first_item); only `cost` adds up.  Batches are
// asked one after the other; the first error ends it, and nothing is answered.  A request whose
// arrays do not fit each other is sent as it is, for the server to say what is wrong with it.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "lucerna/client/client.h"

namespace lucerna::client {

/// More items a batch gain nothing (messages of 32 to 256 KiB travel best).
inline constexpr std::uint32_t kGoodBatchItems = 8192;

/// What every server takes at once, and its messages may be long; more is asked for with
/// GetServerInfo.
inline constexpr std::uint32_t kItemsNotAskedFor = 1024;
inline constexpr std::uint64_t kBytesNotAskedFor = 1 << 20;

/// No batch's question or answer is longer than the server's messages may be, unless a single
/// item's is.
struct BatchOptions {
  /// Items of one batch, at least 1.  0: the server's limit, at most kGoodBatchItems.
  std::uint32_t max_items = 0;
  /// `call.deadline` is for all batches together.
  CallOptions call = {};
};

/// Here an item is a sample: a batch holds max_items / samples receivers, and one at least.  With a
/// target error samples are max_samples; where that is unset each receiver may have as many as if
/// it were asked about alone.  With a time budget it is one request.
absl::StatusOr<v1::SampleLiResponse> sample_li_in_batches(const Client& client,
                                                          const v1::SampleLiRequest& request,
                                                          const BatchOptions& options = {});
absl::StatusOr<v1::PdfLiResponse> pdf_li_in_batches(const Client& client,
                                                    const v1::PdfLiRequest& request,
                                                    const BatchOptions& options = {});
/// Here an item is a ray.
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
/// With `per_light` the scene is asked for (GetScene) how many lights it has.  With a time budget
/// it is one request.
absl::StatusOr<v1::EstimateIrradianceResponse> estimate_irradiance_in_batches(
    const Client& client, const v1::EstimateIrradianceRequest& request,
    const BatchOptions& options = {});

}  // namespace lucerna::client
