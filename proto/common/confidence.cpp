#include "proto/common/confidence.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace lucerna {
namespace {

/// With at least this many samples that count, a sum of rare events is close enough to normal.
constexpr double kMany = 64;
/// Samples are not rare if more than this share of them counts.
constexpr double kCommon = 0.25;
/// (1 + skewness^2) / kurtosis is 1 for samples of two values.  It is 0.56 for evenly spread
/// samples, and about 0.4 to 0.5 for direct light of a lamp.  The rule for two values counts in
/// full from kTwoValues, not at all up to kSpread, and in part between.
constexpr double kSpread = 0.6, kTwoValues = 0.8;
/// Samples are equal if their standard deviation is at most this share of their mean.
constexpr double kEqual = 0x1p-10;
/// Means of blocks are equal up to rounding.
constexpr double kRounded = 1e-12;

// Overflowed parameters are not an error; there is no interval then.
using Quiet = boost::math::policies::policy<
    boost::math::policies::domain_error<boost::math::policies::ignore_error>,
    boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
    boost::math::policies::evaluation_error<boost::math::policies::ignore_error>>;
using StudentsT = boost::math::students_t_distribution<double, Quiet>;
using ChiSquared = boost::math::chi_squared_distribution<double, Quiet>;

/// The `below` quantile of a sum of weighted Poisson counts with this mean and variance.
/// Approximated by a scaled chi-squared variable with the same mean and variance.
double weighted_counts_quantile(double mean, double variance, double below) {
  const double scale = variance / mean;
  return scale / 2 * quantile(ChiSquared(2 * (mean / scale)), below);
}

/// The distance between the two values of samples beside an edge; 0 for smooth light.
double jump(const EstimateMoments& m) {
  const double two_valued = (1 + m.skewness * m.skewness) / m.kurtosis;
  if (!(two_valued > kSpread)) return 0;
  return std::min(1.0, (two_valued - kSpread) / (kTwoValues - kSpread)) * m.deviation *
         std::sqrt(4 + m.skewness * m.skewness);
}

}  // namespace

double student_quantile(double freedom, double tail) {
  return quantile(complement(StudentsT(freedom), tail));
}

double student_p(double deviations, double freedom) {
  if (std::isnan(deviations)) return 1;
  if (std::isinf(deviations)) return 0;
  return std::min(1.0, 2 * cdf(complement(StudentsT(freedom), std::fabs(deviations))));
}

IntervalRule::IntervalRule(double confidence, std::uint64_t blocks, std::uint64_t samples)
    : confidence_(confidence),
      samples_(static_cast<double>(samples)),
      per_replicate_(samples_ / static_cast<double>(std::max<std::uint64_t>(blocks, 1))),
      student_(blocks < 2
                   ? std::numeric_limits<double>::infinity()
                   : student_quantile(static_cast<double>(blocks - 1), (1 - confidence) / 2)),
      rare_(-std::log1p(-confidence)) {}

double IntervalRule::skewed(double skewness) const {
  return std::max(0.0, skewness) / std::sqrt(samples_) * (2 * student_ * student_ + 1) /
         (6 * student_);
}

ConfidenceInterval IntervalRule::signed_interval(const EstimateMoments& m) const {
  // At most this share of all samples is of a kind that none of them shows.
  const double share = std::min(1.0, rare_ / samples_);
  if (!(m.sum_of_squares > 0)) return {m.mean - share * m.largest, m.mean + share * m.largest};
  if (std::isinf(student_)) return {-student_, student_};
  const double square = m.sum_of_squares / samples_, variance = m.deviation * m.deviation;
  const double fourth = variance * variance * m.kurtosis +
                        4 * m.mean * variance * m.deviation * m.skewness +
                        6 * m.mean * m.mean * variance + m.mean * m.mean * m.mean * m.mean;
  // The magnitude of the samples that count, and their number.
  const double size = std::sqrt(fourth / square), counting = samples_ * (square / fourth * square);
  const double scatter = student_ * m.standard_error;
  const double off = std::hypot(scatter, share * 2 * size);
  ConfidenceInterval result{m.mean - std::max(off, scatter * (1 + skewed(-m.skewness))),
                            m.mean + std::max(off, scatter * (1 + skewed(m.skewness)))};
  if (counting < std::min(kMany, kCommon * samples_)) {
    // The sums of positive and of negative samples, and how far the ends of their intervals are.
    const double magnitude = std::max(counting * size / samples_, std::fabs(m.mean));
    const double tail = (1 - confidence_) / 2, weight = m.largest / samples_;
    const auto ends = [&](double sum) {
      const double of_sum = square / samples_ * (sum / magnitude);
      const double lower = sum > 0 ? weighted_counts_quantile(sum, of_sum, tail) : 0;
      return ConfidenceInterval{
          sum - lower,
          weighted_counts_quantile(sum + weight, of_sum + weight * weight, 1 - tail) - sum};
    };
    const ConfidenceInterval positive = ends((magnitude + m.mean) / 2),
                             negative = ends((magnitude - m.mean) / 2);
    result.lower = std::min(result.lower, m.mean - std::hypot(positive.lower, negative.upper));
    result.upper = std::max(result.upper, m.mean + std::hypot(positive.upper, negative.lower));
  }
  return result;
}

ConfidenceInterval IntervalRule::interval(const EstimateMoments& m) const {
  if (m.may_be_negative) return signed_interval(m);
  if (!(m.mean > 0)) {
    // At most this share of all samples is not 0.
    const double share = std::min(1.0, rare_ / samples_);
    return {0, m.largest > 0 ? share * m.largest : 0};
  }
  if (std::isinf(student_)) return {0, student_};
  const double mean_square = m.sum_of_squares / samples_;
  const double scatter = student_ * m.standard_error;
  double unseen = std::max(m.partly_hidden ? mean_square / m.mean : 0, jump(m));
  const double variance = mean_square - m.mean * m.mean;
  // Without the shape: two values, one of them chosen at least once in each block.
  if (m.kurtosis == 0 && m.standard_error <= kRounded * m.mean && variance > kRounded * mean_square)
    unseen = std::max(unseen, std::sqrt(variance * per_replicate_));
  const double off = std::hypot(scatter, rare_ * unseen / samples_);
  ConfidenceInterval result{m.mean - off,
                            m.mean + std::max(off, scatter * (1 + skewed(m.skewness)))};
  const double counting = samples_ * (m.mean / mean_square * m.mean);
  if (counting < std::min(kMany, kCommon * samples_)) {
    const double tail = (1 - confidence_) / 2;
    const double weight = m.largest / samples_, spread = mean_square / samples_;
    result.lower = std::min(result.lower, weighted_counts_quantile(m.mean, spread, tail));
    result.upper = std::max(result.upper, weighted_counts_quantile(
                                              m.mean + weight, spread + weight * weight, 1 - tail));
  }
  // Samples that come in parts have a smaller sum of squares than their mean allows.
  const double squared = m.mean * m.mean;
  const bool equal = mean_square <= squared * (1 + kEqual * kEqual) &&
                     mean_square >= squared * (1 - kEqual * kEqual);
  if (m.may_be_hidden && !m.partly_hidden && equal)
    result.lower = std::min(result.lower, m.mean * (1 - std::min(1.0, rare_ / samples_)));
  result.lower = std::max(result.lower, 0.0);
  return result;
}

}  // namespace lucerna
