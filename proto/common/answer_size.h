// How large the answers to batches are: what servers refuse by, and clients cut batches by.
#pragma once

#include <cstdint>

#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"

namespace lucerna {

/// Bytes of an answer on the wire, from above.
struct AnswerSize {
  /// Whatever the number of items: the cost (below 100 bytes), tags, lengths and tokens.
  static constexpr std::uint64_t kFixed = 512;

  std::uint64_t fixed = kFixed;
  std::uint64_t per_item = 0;  ///< > 0

  /// How many items an answer of `bytes` holds.
  std::uint64_t items_within(std::uint64_t bytes) const {
    return bytes < fixed ? 0 : (bytes - fixed) / per_item;
  }
};

/// An item is a sample, of which a receiver has `accuracy.samples`, or as many as it is found to
/// need; what is told of each receiver is among what is fixed.
AnswerSize answer_size(const v1::SampleLiRequest& request);
AnswerSize answer_size(const v1::PdfLiRequest& request);
AnswerSize answer_size(const v1::SampleLeRequest& request);
AnswerSize answer_size(const v1::PdfLeRequest& request);
AnswerSize answer_size(const v1::LeRequest& request);
/// An item is a light of the page.
AnswerSize answer_size(const v1::EstimatePowerRequest& request);
AnswerSize answer_size(const v1::TestVisibilityRequest& request);
/// `lights`: of the scene; read where the request asks `per_light`.
AnswerSize answer_size(const v1::EstimateIrradianceRequest& request, std::uint64_t lights);
/// An item is a pixel, in tiles of either call.
AnswerSize tile_size(const v1::Accuracy& accuracy);

}  // namespace lucerna
