// The reference: the answer that all other answers are compared with.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tradeoff/question.h"

namespace lucerna::tradeoff {

struct Reference {
  std::vector<double> values;
  std::vector<double> standard_error;  ///< one for each value; a bound if the reference is exact
  double dark = 1;                     ///< dark_level() of the values
  double relative_error = 0;           ///< root of the mean squared relative standard error
  double rmse = 0;                     ///< the same in the unit of the values
  bool exact = false;
  std::string way;             ///< the estimator, in words
  std::string warning{};       ///< empty if there is no reason for doubt
  std::size_t replicates = 0;  ///< answers with different seeds in the mean
  std::uint32_t samples_each = 0;
  double seconds = 0;  ///< wall time, pilots included
};

/// A smaller relative error is not useful, since this is a tenth of the smallest recommended error.
inline constexpr double kGoodReference = 1e-4;
/// With fewer answers, their scatter does not show the error.
inline constexpr std::size_t kFewestReplicates = 4;

/// Seconds of a monotonic clock.
using Clock = std::function<double()>;

/// The chance that the check refuses a correct closed form or a correct estimator.
inline constexpr double kRefusal = 1e-3;

/// Takes two answers by each estimator of `question`, and chooses the most efficient estimator.
/// Averages its answers with different seeds until `seconds` are spent or the relative error is
/// kGoodReference.  DEADLINE_EXCEEDED, with the required time, if there is no time for
/// kFewestReplicates answers.
///
/// If the chosen estimator needs a check, the best estimator that needs no check gets part of the
/// time.  The check compares the mean of all values, each divided by its reference.  If the means
/// differ by more than Student's interval, the checking answers become the reference, and the
/// result has a warning.
///
/// If automatic has closed forms of all values, each must be within Student's interval of the
/// sampled value.  If so, they become the reference, which has no error.  Otherwise the sampled
/// reference is kept, and the result has a warning.
absl::StatusOr<Reference> make_reference(const Question& question, double seconds,
                                         std::uint64_t seed, const Clock& clock);

/// The same with counts instead of a time: the mean of `answers` answers (at least
/// kFewestReplicates) of `samples` samples.  Uses the first estimator that does not need a check.
absl::StatusOr<Reference> make_counted_reference(const Question& question, std::size_t answers,
                                                 std::uint32_t samples, std::uint64_t seed,
                                                 const Clock& clock);

/// A different seed for each pair of numbers, by the mixing function of splitmix64.  [Steele14]
std::uint64_t mixed_seed(std::uint64_t seed, std::uint64_t number);

}  // namespace lucerna::tradeoff
