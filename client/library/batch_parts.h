// Splits requests into batches and joins the answers, for batches.h.  This header is not installed.
#pragma once

#include <cstddef>
#include <string>

#include "lucerna/v1/lighting.pb.h"

namespace lucerna::client {

/// Receivers, segments or rays of a request; 0 if its arrays do not match each other.
std::size_t item_count(const v1::SampleLiRequest& request);
std::size_t item_count(const v1::PdfLiRequest& request);
std::size_t item_count(const v1::SampleLeRequest& request);
std::size_t item_count(const v1::PdfLeRequest& request);
std::size_t item_count(const v1::LeRequest& request);
std::size_t item_count(const v1::TestVisibilityRequest& request);
std::size_t item_count(const v1::EstimateIrradianceRequest& request);

/// The part of a request with items [first, first + count).  Requires that item_count() is not 0.
v1::SampleLiRequest part(const v1::SampleLiRequest& request, std::size_t first, std::size_t count);
v1::PdfLiRequest part(const v1::PdfLiRequest& request, std::size_t first, std::size_t count);
v1::SampleLeRequest part(const v1::SampleLeRequest& request, std::size_t first, std::size_t count);
v1::PdfLeRequest part(const v1::PdfLeRequest& request, std::size_t first, std::size_t count);
v1::LeRequest part(const v1::LeRequest& request, std::size_t first, std::size_t count);
v1::TestVisibilityRequest part(const v1::TestVisibilityRequest& request, std::size_t first,
                               std::size_t count);
v1::EstimateIrradianceRequest part(const v1::EstimateIrradianceRequest& request, std::size_t first,
                                   std::size_t count);

/// Adds up all counts and times.
void append_cost(const v1::Cost& next, v1::Cost* whole);

/// Appends the answer for the next part to the answers for the earlier parts.
void append(const v1::SampleLiResponse& next, v1::SampleLiResponse* whole);
void append(const v1::PdfLiResponse& next, v1::PdfLiResponse* whole);
void append(const v1::SampleLeResponse& next, v1::SampleLeResponse* whole);
void append(const v1::PdfLeResponse& next, v1::PdfLeResponse* whole);
void append(const v1::LeResponse& next, v1::LeResponse* whole);
void append(const v1::TestVisibilityResponse& next, v1::TestVisibilityResponse* whole);
void append(const v1::EstimateIrradianceResponse& next, v1::EstimateIrradianceResponse* whole);

/// Bit `index` of the contract's bit arrays; false beyond their end.
bool bit(const std::string& bits, std::size_t index);
/// Appends the first `count` bits of `next` to the first `whole_count` bits of `whole`.
void append_bits(const std::string& next, std::size_t count, std::size_t whole_count,
                 std::string* whole);

}  // namespace lucerna::client
