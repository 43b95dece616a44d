// Sizes of answers to batches.  Servers use them to refuse requests, clients to split batches.
#pragma once

#include <cstdint>

#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"

namespace lucerna {

/// An upper bound on the bytes of an answer on the wire.
struct AnswerSize {
  /// For any number of items: the cost (below 100 bytes), tags, lengths and tokens.
  static constexpr std::uint64_t kFixed = 512;

  std::uint64_t fixed = kFixed;
  std::uint64_t per_item = 0;  ///< > 0

  /// The most items in an answer of `bytes`.
  std::uint64_t items_within(std::uint64_t bytes) const {
    return bytes < fixed ? 0 : (bytes - fixed) / per_item;
  }
};

/// Whether the request names a light by id or by name.  Otherwise the server chooses one for each
/// item.
template <typename Request>
bool names_light(const Request& request) {
  return request.has_light_id() || !request.light_name().empty();
}

/// An item is a sample.  A receiver has `accuracy.samples` of them, or as many as its target error
/// or the time budget allows.  Estimates of receivers count as fixed.
AnswerSize answer_size(const v1::SampleLiRequest& request);
AnswerSize answer_size(const v1::PdfLiRequest& request);
AnswerSize answer_size(const v1::SampleLeRequest& request);
AnswerSize answer_size(const v1::PdfLeRequest& request);
AnswerSize answer_size(const v1::LeRequest& request);
/// An item is a light of the page.
AnswerSize answer_size(const v1::EstimatePowerRequest& request);
/// `is_partial`: whether the answer has shares of light.
AnswerSize answer_size(const v1::TestVisibilityRequest& request, bool is_partial);
/// `lights`: the number in the scene; used only with `per_light`.
AnswerSize answer_size(const v1::EstimateIrradianceRequest& request, std::uint64_t lights);
AnswerSize answer_size(const v1::FindSurfacesRequest& request);
/// An item is a pixel, in tiles of either call.
AnswerSize tile_size(const v1::Accuracy& accuracy, bool intervals);

}  // namespace lucerna
