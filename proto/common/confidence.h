// Intervals that hold the converged value of an estimate.
#pragma once

#include <cstdint>

namespace lucerna {

struct ConfidenceInterval {
  double lower = 0, upper = 0;
};

/// The default confidence of intervals.
inline constexpr double kConfidence = 0.95;

/// Moments of an estimate that is the mean of samples.
struct EstimateMoments {
  double mean = 0;
  double standard_error = 0;  ///< from the scatter of the blocks
  double sum_of_squares = 0;  ///< over all samples
  /// The largest magnitude that a missed sample may have, by the samples so far.
  double largest = 0;
  /// Some samples were shadowed.
  bool partly_hidden = false;
  /// Samples decide whether an obstacle hides the light.
  bool may_be_hidden = false;
  /// Shape of the samples' distribution; 0 if it is not known, or if the samples are equal.
  double deviation = 0;  ///< standard deviation of the samples
  double skewness = 0;
  double kurtosis = 0;  ///< not the excess; at least 1
  /// Samples, and the converged value, may be negative.  Needs the shape.
  bool may_be_negative = false;
};

/// The number that a variable of Student's t distribution with `freedom` > 0 degrees exceeds with
/// probability `tail`.
double student_quantile(double freedom, double tail);
/// The two-sided p-value of `deviations` of this distribution.
double student_p(double deviations, double freedom);

/// Computes intervals of estimates with equal sample counts.  Immutable.
class IntervalRule {
 public:
  /// `confidence` in (0, 1).  `blocks`: number of independent means, each of equally many
  /// samples.
  IntervalRule(double confidence, std::uint64_t blocks, std::uint64_t samples);

  /// An interval that contains the converged value.  The confidence is close to the requested one
  /// if many samples contribute, and at least that if few do.
  ///
  /// Replicates of low-discrepancy points are independent, so their mean has Student's distribution
  /// [LEcuyer23].  This requires some light in most blocks.  (sum)^2 / sum of squares is the
  /// number of samples that count.  If it is small, these samples are rare events of different
  /// weight.  For them [Fay97] gives an interval that may be too wide but not too narrow.  The
  /// result then covers both intervals.  If all samples were 0, it is the rule of three.
  ///
  /// If some samples were shadowed, each block of low-discrepancy points has nearly the same
  /// number of them.  The means of blocks then differ by one sample or not at all.  So the rule
  /// of three for a value that no block had is added to Student's width.  Obstacles that no
  /// sample met are unknown.  With 95% confidence, they hide less than three samples' share of the
  /// light.  The scatter of samples covers this, unless they are equal to kEqual: a light of almost
  /// one direction.  The lower end is then lower by this share.
  ///
  /// Replicates that choose among mirrors may have equal means although their samples differ.  Then
  /// the rule of three for one more sample of the rarest value adds to the width.
  ///
  /// Beside an edge the samples have two values.  Each block then has nearly the same number of
  /// each, and the rule of three for one more of the other value is added in the same way.  The
  /// distance of the values is that of the two-point distribution with the samples' deviation and
  /// skewness.  The kurtosis shows how close the samples are to two values: it is at least
  /// 1 + skewness^2, and equal to it for exactly two.  [Pearson16]
  ///
  /// Means of few skewed samples lie below the converged value more often than above it.  The upper
  /// end is moved by the first term of the Cornish-Fisher expansion of Student's t.  [Hall92]
  ///
  /// The upper end is infinite if there is one block and some light.
  ///
  /// Samples that may be negative belong to a pixel filter with negative weights.  Both ends then
  /// follow the same rules, and none of them ends at 0:
  /// - If all samples were 0, the rule of three holds for both signs.
  /// - The share of negative samples is nearly the same in each block, as beside an edge.  So
  ///   the rule of three for one sample of the other sign always adds to the width.
  /// - The end on the side of the skewness is moved.
  /// - (sum of squares)^2 / sum of fourth powers is the number of samples that count.  If it is
  ///   small, positive and negative samples are two sums of rare events, each with the interval of
  ///   [Fay97].  [Zou08] combines them to an interval of their difference.
  ConfidenceInterval interval(const EstimateMoments& m) const;

 private:
  ConfidenceInterval signed_interval(const EstimateMoments& m) const;
  /// How much farther than Student's the end on the side of the skewness is.
  double skewed(double skewness) const;

  double confidence_;
  double samples_, per_replicate_;
  double student_;  ///< quantile for the number of blocks; infinite for one
  double rare_;     ///< largest expected number of events where none occurred
};

}  // namespace lucerna
