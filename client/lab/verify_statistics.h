// The tests behind `lucerna verify`.  docs/decisions/058-verify.md gives their reasons.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "client/lab/partition.h"

namespace lucerna::verify {

/// The result of one test.
struct TestResult {
  /// The probability of a deviation at least as large, if nothing is wrong.  Nothing if there were
  /// too few rows for this test.
  std::optional<double> p;
  std::size_t cells = 0;
  /// The cell with the largest deviation, and its weight over the expected weight.
  std::size_t worst_cell = 0;
  double worst_ratio = 1;
};

/// Tests whether samples follow a density, by importance weights.
///
/// The samples were drawn with the claimed density c.  `weights` are q / c, where q is a known
/// density, whose cells have the probabilities of `partition`.  If the claim is right, then the
/// mean weight in each cell is proportional to the cell's probability.  The common factor is
/// fitted, so this test is about shape only; see mean_is_one().  Weights of 1 give Pearson's test
/// against q.
///
/// `reference` is the number of samples from which the probabilities come; their error counts.
TestResult cells_have_probabilities(const Partition& partition,
                                    const std::vector<std::size_t>& cells,
                                    const std::vector<double>& weights, double reference);

/// The mean of weights, which is 1 if the claimed density is right.  One over it estimates the
/// integral of the claimed density.
struct MeanResult {
  double mean = 0;
  double standard_error = 0;
  std::optional<double> p;  ///< as in TestResult
};

/// Tests whether the mean is `expected` within `tolerance` and noise.  `expected_error` is the
/// standard error of `expected`.  The upper and lower tails are corrected for skewness [Hall92b].
MeanResult mean_is(const std::vector<double>& values, double expected, double tolerance,
                   double expected_error = 0);

/// Adjusts p-values for their number [Holm79].  A test is rejected at a level if its adjusted value
/// is at most the level.  Then the chance of any false rejection is at most the level.
std::vector<double> holm(const std::vector<double>& p);

}  // namespace lucerna::verify
