// Measures how often intervals hold the converged value: many answers to one query, with
// different seeds, against the known value.
#pragma once

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/common/confidence.h"
#include "tests/server/extremes/wire_settings.h"

namespace lucerna::testing {

/// Repeats of each query: 1000, or the number in the environment (`make soak`: 4000).
inline std::uint64_t repeats() {
  const absl::StatusOr<std::uint64_t> n = whole_number_of("LUCERNA_REPEATS", 1000, 1000);
  if (!n.ok()) throw std::runtime_error(std::string(n.status().message()));
  return *n;
}

/// Whether there is time for the largest sample counts, the smallest targets and all edges.
inline bool has_time_for_large_counts() { return repeats() > 1000; }

/// Answers to one query whose converged value is `truth`.
class Coverage {
 public:
  explicit Coverage(double truth) : truth_(truth) {}

  void add(double estimate, const ConfidenceInterval& interval) {
    ++count_;
    const double off = (estimate - mean_) / static_cast<double>(count_);
    squares_ += (estimate - mean_) * (estimate - mean_ - off);
    mean_ += off;
    held_ += interval.lower <= truth_ && truth_ <= interval.upper;
  }

  double held() const { return static_cast<double>(held_) / static_cast<double>(count_); }
  /// The standard deviation of a measured `share`: four of these are exceeded by chance once
  /// in 16000 times.
  double deviation_of(double share) const {
    return std::sqrt(share * (1 - share) / static_cast<double>(count_));
  }
  /// At least 93%, within the accuracy of the number of repeats.
  bool holds_enough() const { return held() >= 0.93 - slack(); }
  /// At most 97%: wider intervals are not needed.
  bool holds_no_more() const { return held() <= 0.97 + slack(); }
  /// The difference of the answers' mean from the converged value, in standard errors of the
  /// mean.
  double bias() const {
    const double n = static_cast<double>(count_);
    return (mean_ - truth_) / std::sqrt(squares_ / (n * (n - 1)));
  }

 private:
  /// For 4000 repeats the limits are 93% and 97%: an interval of exactly 95% is 5.8 standard
  /// deviations away from them.  Fewer repeats have wider limits at the same distance.
  double slack() const { return std::max(0.0, 5.8 * deviation_of(0.95) - 0.02); }

  double truth_;
  std::uint64_t count_ = 0, held_ = 0;
  double mean_ = 0, squares_ = 0;
};

/// An answer to a query: an estimate and the interval about it.
struct Answer {
  double value = 0;
  ConfidenceInterval interval;
};

/// The i-th of repeats() answers is `answer(i)`.
template <typename AnswerOf>
Coverage repeated(double truth, const AnswerOf& answer) {
  std::vector<Answer> answers(repeats());
  tbb::parallel_for(std::size_t{0}, answers.size(), [&](std::size_t i) { answers[i] = answer(i); });
  Coverage c(truth);
  for (const Answer& a : answers) c.add(a.value, a.interval);
  return c;
}

/// For queries that many samples answer.
inline void expect_covered(const Coverage& c, const std::string& what) {
  EXPECT_TRUE(c.holds_enough()) << what << ": " << c.held();
  EXPECT_TRUE(c.holds_no_more()) << what << ": " << c.held();
  EXPECT_LE(std::fabs(c.bias()), 4) << what;
}

/// For queries where few samples count: intervals may be too wide.
inline void expect_covered_at_least(const Coverage& c, const std::string& what) {
  EXPECT_TRUE(c.holds_enough()) << what << ": " << c.held();
  EXPECT_LE(std::fabs(c.bias()), 4) << what;
}

/// How often a query with a target error is repeated.
inline std::size_t target_repeats() { return has_time_for_large_counts() ? 4000 : 1000; }
/// The relative error that they request.
inline constexpr double kTargetRelative = 0.05;

/// Checks that 95% of the answers are within kTargetRelative: three standard deviations more than
/// exactly 95%.  `estimate(i)` is the i-th of target_repeats() answers.
template <typename Estimate>
void expect_reached(double truth, Estimate&& estimate, const std::string& what) {
  const std::size_t n = target_repeats();
  std::size_t reached = 0;
  for (std::size_t i = 0; i < n; ++i)
    reached += std::fabs(estimate(i) - truth) <= kTargetRelative * truth;
  const double count = static_cast<double>(n);
  EXPECT_GE(static_cast<double>(reached) / count, 0.95 + 3 * std::sqrt(0.95 * 0.05 / count))
      << what;
}

}  // namespace lucerna::testing
