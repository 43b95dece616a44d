// Where the converged value lies, given the samples of an estimate.
#pragma once

#include <cstdint>

namespace lucerna {

struct Interval {
  double lower = 0, upper = 0;
};

/// Of intervals for which nobody asked for another.
inline constexpr double kConfidence = 0.95;

/// When an estimate is good enough.
struct TargetError {
  double relative = 0;              ///< of the estimate, > 0
  double absolute_floor = 0;        ///< no smaller error is asked for; in the estimate's unit
  double confidence = kConfidence;  ///< of the interval, in (0, 1)
  std::uint64_t max_samples = 1U << 16;
};

/// What is known of an estimate, the mean of samples that are not negative.
struct EstimateMoments {
  double mean = 0;
  double standard_error = 0;  ///< by the scatter of the replicates that the samples came in
  double sum_of_squares = 0;  ///< over all samples
  /// No sample that may have been missed is larger, as far as is known.
  double largest = 0;
  /// Something was in the way of some samples.
  bool partly_hidden = false;
};

/// Intervals of estimates that take equally many samples; immutable.
class IntervalRule {
 public:
  /// `confidence` in (0, 1); `replicates`: independent means, of equally many samples each.
  IntervalRule(double confidence, std::uint64_t replicates, std::uint64_t samples);

  /// Holds the converged value with about that confidence where many samples contribute, and with
  /// at least that where few do.
  ///
  /// Replicates of low-discrepancy points are independent, so their mean has Student's
  /// distribution [LEcuyer23].  That asks for some light in most of them.  Where few samples count,
  /// (sum)^2 / sum of squares of them, they are rare events of different weight, for which
  /// [Fay97] gives an interval that may be too wide but not too narrow; the answer is then what
  /// holds both.  Where all were 0 that is what is left of the rule of three.
  ///
  /// Where something was in the way of some samples, replicates of low-discrepancy points have
  /// nearly as many of those each: their means are then a few values apart by one sample, and those
  /// that came up may be all alike.  So the interval is as wide as the rule of three says of a
  /// value that none of the replicates had, and Student's together.  Of obstacles that no sample
  /// met, it knows nothing: with 95% confidence they hide less than three samples' share of the
  /// light.
  ///
  /// Infinite above where there is but one replicate, and some light.
  Interval interval(const EstimateMoments& m) const;

 private:
  double confidence_;
  double samples_;
  double student_;  ///< quantile for so many replicates; infinite for one
  double rare_;     ///< events that are expected where none came up, at most
};

}  // namespace lucerna
