#include "proto/common/luminance_moments.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace lucerna {
namespace {

constexpr float kLargestFloat = std::numeric_limits<float>::max();

/// Powers of a larger number would not fit a double.
double held(double v) { return std::clamp<double>(v, -kLargestFloat, kLargestFloat); }

float rounded_down(double v) {
  const auto f = static_cast<float>(v);
  return f > v ? std::nextafter(f, -kLargestFloat) : f;
}

float rounded_up(double v) {
  // A bound that does not fit a float, or whose squares overflowed a double, becomes the largest
  // float.
  if (!(v < kLargestFloat)) return kLargestFloat;
  const auto f = static_cast<float>(v);
  return f < v ? std::nextafter(f, kLargestFloat) : f;
}

}  // namespace

LuminanceMoments merge(const LuminanceMoments& a, std::uint64_t na, const LuminanceMoments& b,
                       std::uint64_t nb) {
  if (na == 0) return b;
  if (nb == 0) return a;
  const auto p = static_cast<double>(na), q = static_cast<double>(nb);
  const double n = p + q, d = b.blocks.sum / q - a.blocks.sum / p;
  return {.blocks = merge(a.blocks, na, b.blocks, nb),
          .second = a.second + b.second + d * d * (p * q / n),
          .third = a.third + b.third + d * d * d * (p * q * (p - q) / (n * n)) +
                   3 * d * (p * b.second - q * a.second) / n,
          .fourth = a.fourth + b.fourth +
                    d * d * d * d * (p * q * (p * p - p * q + q * q) / (n * n * n)) +
                    6 * d * d * (p * p * b.second + q * q * a.second) / (n * n) +
                    4 * d * (p * b.third - q * a.third) / n,
          .largest = std::max(a.largest, b.largest),
          .partly_hidden = a.partly_hidden || b.partly_hidden,
          .may_be_negative = a.may_be_negative || b.may_be_negative};
}

EstimateMoments estimate_moments(const LuminanceMoments& m, std::uint64_t count,
                                 std::uint64_t samples) {
  const auto n = static_cast<double>(count);
  const double mean = m.blocks.sum / n, variance = m.second / n;
  EstimateMoments result{
      .mean = mean,
      .standard_error = count > 1 ? std::sqrt(m.blocks.deviation / (n * (n - 1))) : 0,
      .sum_of_squares = static_cast<double>(samples) * (variance + mean * mean),
      .largest = m.largest,
      .partly_hidden = m.partly_hidden,
      .may_be_negative = m.may_be_negative};
  if (variance > 0) {
    result.deviation = std::sqrt(variance);
    result.skewness = m.third / n / (variance * result.deviation);
    result.kurtosis = std::max(m.fourth / n / (variance * variance), 1.0);
  }
  return result;
}

void BlockMoments::add(double value, double unshadowed) {
  value = held(value);
  unshadowed = held(unshadowed);
  if (count_ == 0) first_ = value;
  ++count_;
  double power = 1;
  for (double& sum : sums_) sum += power *= value - first_;
  largest_ = std::max(largest_, unshadowed);
  partly_hidden_ |= std::fabs(value) < unshadowed;
}

LuminanceMoments BlockMoments::result(double mean) const {
  const double a = sums_[0] / count_, b = sums_[1] / count_, c = sums_[2] / count_,
               d = sums_[3] / count_;
  return {.blocks = {mean, 0},
          .second = std::max(0.0, b - a * a),
          .third = c - 3 * a * b + 2 * a * a * a,
          .fourth = std::max(0.0, d - 4 * a * c + 6 * a * a * b - 3 * a * a * a * a),
          .largest = largest_,
          .partly_hidden = partly_hidden_,
          .may_be_negative = may_be_negative_};
}

std::string bytes_of(std::span<const LuminanceMoments> moments) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes(moments.size() * kMomentBytes, '\0');
  char* to = bytes.data();
  for (const LuminanceMoments& m : moments) {
    const double numbers[] = {m.blocks.sum,
                              m.blocks.deviation,
                              m.second,
                              m.third,
                              m.fourth,
                              m.largest,
                              (m.partly_hidden ? 1.0 : 0.0) + (m.may_be_negative ? 2.0 : 0.0)};
    static_assert(sizeof numbers == kMomentBytes);
    std::memcpy(to, numbers, sizeof numbers);
    to += sizeof numbers;
  }
  return bytes;
}

std::vector<LuminanceMoments> moments_of(std::string_view bytes) {
  std::vector<LuminanceMoments> moments(bytes.size() / kMomentBytes);
  const char* from = bytes.data();
  for (LuminanceMoments& m : moments) {
    double numbers[kMomentBytes / sizeof(double)];
    std::memcpy(numbers, from, sizeof numbers);
    from += sizeof numbers;
    m = {.blocks = {numbers[0], numbers[1]},
         .second = numbers[2],
         .third = numbers[3],
         .fourth = numbers[4],
         .largest = numbers[5],
         .partly_hidden = numbers[6] != 0 && numbers[6] != 2,
         .may_be_negative = numbers[6] >= 2};
  }
  return moments;
}

FloatInterval rounded_outwards(const ConfidenceInterval& interval, float least) {
  const float upper = rounded_up(interval.upper);
  if (!(interval.lower > least)) return {std::min(least, upper), upper};
  return {std::min(rounded_down(interval.lower), upper), upper};
}

float least_value(bool may_be_negative) { return may_be_negative ? -kLargestFloat : 0; }

std::vector<FloatInterval> pixel_intervals(std::span<const LuminanceMoments> moments,
                                           std::uint64_t blocks, std::uint64_t samples_per_block) {
  const std::uint64_t samples = blocks * samples_per_block;
  const IntervalRule rule(kConfidence, blocks, samples);
  std::vector<FloatInterval> result;
  result.reserve(moments.size());
  for (const LuminanceMoments& m : moments)
    result.push_back(rounded_outwards(rule.interval(estimate_moments(m, blocks, samples)),
                                      least_value(m.may_be_negative)));
  return result;
}

}  // namespace lucerna
