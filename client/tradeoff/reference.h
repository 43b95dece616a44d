// The answer that all other answers are compared with.
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
  std::vector<double> standard_error;  ///< one a value; a bound where the reference is exact
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

/// A smaller relative error is not useful: it is a tenth of the smallest recommended error.
inline constexpr double kGoodReference = 1e-4;
/// Fewer answers do not show an error.
inline constexpr std::size_t kFewestReplicates = 4;

/// Seconds on a clock that only goes forward.
using Clock = std::function<double()>;

/// The chance that the check refuses a correct closed form or a correct estimator.
inline constexpr double kRefusal = 1e-3;

/// Takes two answers by each estimator of `question` and chooses the most efficient estimator.
/// Averages its answers with different seeds until `seconds` are spent or the relative error is
/// kGoodReference.  DEADLINE_EXCEEDED, with the time it needs, if kFewestReplicates do not fit.
///
/// If the chosen estimator needs a check, part of the time goes to the best estimator that needs
/// none.  The check compares the mean of all values, each divided by its reference.  If the means
/// differ by more than Student's interval, the checking answers become the reference, and the
/// result has a warning.
///
/// If automatic has closed forms of all values, they become the reference, without error, when
/// every value lies in Student's interval of the sampled one.  Else the sampled reference stays,
/// and the result has a warning.
absl::StatusOr<Reference> make_reference(const Question& question, double seconds,
                                         std::uint64_t seed, const Clock& clock);

/// The same by counts and not by time: the mean of `answers` answers, at least kFewestReplicates,
/// of `samples` samples, by the first estimator that needs no check.
absl::StatusOr<Reference> make_counted_reference(const Question& question, std::size_t answers,
                                                 std::uint32_t samples, std::uint64_t seed,
                                                 const Clock& clock);

/// Another seed for each pair of numbers, by the mixing function of splitmix64.  [Steele14]
std::uint64_t mixed_seed(std::uint64_t seed, std::uint64_t number);

}  // namespace lucerna::tradeoff
