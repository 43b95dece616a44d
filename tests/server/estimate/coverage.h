// Whether intervals hold what they say they hold: many answers to the same question, with different
// seeds, against the converged value.
#pragma once

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/estimate/statistics/confidence.h"
#include "tests/server/extremes/wire_settings.h"

namespace lucerna::testing {

/// How often each question is repeated: 1000 times, or as the environment says (`make soak`: 4000).
inline std::uint64_t repeats() {
  const absl::StatusOr<std::uint64_t> n = whole_number_of("LUCERNA_REPEATS", 1000, 1000);
  if (!n.ok()) throw std::runtime_error(std::string(n.status().message()));
  return *n;
}

/// Answers to one question, whose converged value is `truth`.
class Coverage {
 public:
  explicit Coverage(double truth) : truth_(truth) {}

  /// `widened`: the interval is, about its estimate.
  void add(double estimate, const Interval& interval, double widened = 1) {
    ++count_;
    const double off = (estimate - mean_) / static_cast<double>(count_);
    squares_ += (estimate - mean_) * (estimate - mean_ - off);
    mean_ += off;
    held_ += estimate - widened * (estimate - interval.lower) <= truth_ &&
             truth_ <= estimate + widened * (interval.upper - estimate);
  }

  double held() const { return static_cast<double>(held_) / static_cast<double>(count_); }
  /// Of `share`, when it is that of so many repeats: four of these happen once in 16000 times.
  double deviation_of(double share) const {
    return std::sqrt(share * (1 - share) / static_cast<double>(count_));
  }
  /// At least 93%, as far as so many repeats can tell.
  bool holds_enough() const { return held() >= 0.93 - slack(); }
  /// At most 97%: wider intervals were not needed.
  bool holds_no_more() const { return held() <= 0.97 + slack(); }
  /// The mean of the answers, in their own standard errors off the converged value.
  double bias() const {
    const double n = static_cast<double>(count_);
    return (mean_ - truth_) / std::sqrt(squares_ / (n * (n - 1)));
  }

 private:
  /// 4000 repeats are held to 93% and 97% themselves: an interval of just 95% is 5.8 of their
  /// standard deviations away.  Fewer are allowed what keeps it so.
  double slack() const { return std::max(0.0, 5.8 * deviation_of(0.95) - 0.02); }

  double truth_;
  std::uint64_t count_ = 0, held_ = 0;
  double mean_ = 0, squares_ = 0;
};

/// An answer to a question: an estimate and the interval about it.
struct Answer {
  double value = 0;
  Interval interval;
};

/// The i-th of repeats() answers is `ask(i)`; intervals are made `widened` times as wide.
template <typename Ask>
Coverage repeated(double truth, double widened, const Ask& ask) {
  std::vector<Answer> answers(repeats());
  tbb::parallel_for(std::size_t{0}, answers.size(), [&](std::size_t i) { answers[i] = ask(i); });
  Coverage c(truth);
  for (const Answer& a : answers) c.add(a.value, a.interval, widened);
  return c;
}

/// For questions that many samples answer.
inline void expect_covered(const Coverage& c, const std::string& what) {
  EXPECT_TRUE(c.holds_enough()) << what << ": " << c.held();
  EXPECT_TRUE(c.holds_no_more()) << what << ": " << c.held();
  EXPECT_LE(std::fabs(c.bias()), 4) << what;
}

/// For those of which few samples tell anything: intervals may be too wide.
inline void expect_covered_at_least(const Coverage& c, const std::string& what) {
  EXPECT_TRUE(c.holds_enough()) << what << ": " << c.held();
  EXPECT_LE(std::fabs(c.bias()), 4) << what;
}

/// That intervals of a wrong variance are seen: `asked(widened)` has each that much wider.
template <typename Asked>
void expect_sees_wrong_widths(Asked&& asked) {
  const Coverage narrow = asked(0.6), wide = asked(1.8);
  EXPECT_FALSE(narrow.holds_enough()) << narrow.held();
  EXPECT_FALSE(wide.holds_no_more()) << wide.held();
}

/// Of a question with a target error.
inline constexpr std::size_t kTargetQuestions = 4000;

/// That answers within 2% with 95% confidence are, for certain: of 95% just met, three standard
/// deviations more.  `estimate(i)` is one of kTargetQuestions.
template <typename Estimate>
void expect_reached(double truth, Estimate&& estimate, const std::string& what) {
  std::size_t reached = 0;
  for (std::size_t i = 0; i < kTargetQuestions; ++i)
    reached += std::fabs(estimate(i) - truth) <= 0.02 * truth;
  EXPECT_GE(static_cast<double>(reached) / kTargetQuestions, 0.9603) << what;
}

}  // namespace lucerna::testing
