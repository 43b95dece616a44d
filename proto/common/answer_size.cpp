#include "proto/common/answer_size.h"

#include "proto/common/luminance_moments.h"

namespace lucerna {
namespace {

// Upper bounds on the wire.  A bit counts as a byte.
constexpr std::uint64_t kBit = 1;
constexpr std::uint64_t kFloat = 4;
constexpr std::uint64_t kDouble = 8;
constexpr std::uint64_t kId = 10;     // a 64-bit varint
constexpr std::uint64_t kCount = 5;   // a 32-bit varint
constexpr std::uint64_t kStatus = 1;  // a varint below 128
constexpr std::uint64_t kTag = 1;     // of a field below 16
constexpr std::uint64_t kLength = 5;  // a 31-bit varint

/// If the server chooses a light for each item, the answer has its id and probability.
template <typename Request>
std::uint64_t choice(const Request& request) {
  return names_light(request) ? 0 : kId + kDouble;
}

template <typename Request>
std::uint64_t wavelengths(const Request& request) {
  return static_cast<std::uint64_t>(request.wavelengths_nm_size());
}

}  // namespace

AnswerSize answer_size(const v1::SampleLiRequest& request) {
  // Value, wi, distance, point, normal, density; delta and visible.
  const std::uint64_t transmittance = request.test_visibility() ? 3 * kFloat : 0;
  const std::uint64_t sample =
      (3 + 3 + 1 + 3 + 3 + 1) * kFloat + 2 * kBit + transmittance + kStatus;
  std::uint64_t estimates = 0;
  if (request.accuracy().has_target_error() || request.accuracy().has_time_budget_s()) {
    // Count, illuminance, error and interval, wavelengths and their errors.
    const std::uint64_t receiver =
        kCount + 4 * kFloat + 2 * kFloat * wavelengths(request) + kStatus;
    estimates = static_cast<std::uint64_t>(request.receivers().offsets_m_size()) / 3 * receiver;
  }
  return {.fixed = AnswerSize::kFixed + estimates,
          .per_item = sample + choice(request) + kFloat * wavelengths(request)};
}

AnswerSize answer_size(const v1::PdfLiRequest&) { return {.per_item = kFloat + kStatus}; }

AnswerSize answer_size(const v1::SampleLeRequest& request) {
  // Point, direction, normal, value, two densities.
  const std::uint64_t ray = (3 + 3 + 3 + 3 + 2) * kFloat + kStatus;
  return {.per_item = ray + choice(request) + kFloat * wavelengths(request)};
}

AnswerSize answer_size(const v1::PdfLeRequest&) { return {.per_item = 2 * kFloat + kStatus}; }

AnswerSize answer_size(const v1::LeRequest& request) {
  return {.per_item = 3 * kFloat + kId + kStatus + kFloat * wavelengths(request)};
}

AnswerSize answer_size(const v1::EstimatePowerRequest& request) {
  // RGB in its message, flux, error, watts, unit and the array of wavelengths; if sampled, also
  // standard error, interval and count.
  constexpr std::uint64_t kUnit = 16;  // "umol/s"
  const std::uint64_t rgb = kTag + kLength + 3 * (kTag + kDouble);
  const std::uint64_t power = kTag + kLength + kTag + kId + rgb + 3 * (kTag + kDouble) + kUnit +
                              kTag + kLength + kDouble * wavelengths(request) +
                              3 * (kTag + kDouble) + kTag + kId;
  // The total is one more message.
  return {.fixed = AnswerSize::kFixed + power, .per_item = power};
}

AnswerSize answer_size(const v1::TestVisibilityRequest&, bool is_partial) {
  return {.per_item = kBit + kStatus + (is_partial ? 3 * kFloat : 0)};
}

AnswerSize answer_size(const v1::EstimateIrradianceRequest& request, std::uint64_t lights) {
  const std::uint64_t shares = request.per_light() ? lights : 0;
  // Illuminance, error and interval, also of each share; RGB and both bounds.
  const std::uint64_t estimate = 4 * kFloat;
  const std::uint64_t cost = request.accuracy().has_target_error() ? 2 * kId + kFloat : 0;
  return {.fixed = AnswerSize::kFixed + shares * (5 * (kTag + kLength) + kTag + kId),
          .per_item = estimate + (3 + 2) * kFloat + kStatus + cost + shares * estimate +
                      2 * kFloat * wavelengths(request)};
}

AnswerSize answer_size(const v1::FindSurfacesRequest&) {
  // Point and normal; whether it was found; the light.
  return {.per_item = (3 + 3) * kFloat + kBit + kId + kStatus};
}

AnswerSize tile_size(const v1::Accuracy& accuracy, bool intervals) {
  // Sum and squared deviation of each channel; samples, interval and moments.
  std::uint64_t more = 0;
  if (accuracy.has_target_error()) {
    more = 3 * kFloat;
  } else if (intervals) {
    more = 2 * kFloat + kMomentBytes;
  }
  return {.per_item = std::uint64_t{2} * 3 * kDouble + more};
}

}  // namespace lucerna
