// The answer that all others are compared with.
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
  std::vector<double> standard_error;  ///< of each; a bound where it is exact
  double dark = 1;                     ///< dark_level() of the values
  double relative_error = 0;           ///< its own: root of the mean squared relative one
  double rmse = 0;                     ///< in the unit of the values
  bool exact = false;
  std::string way;             ///< in words
  std::string warning{};       ///< in words, where there is something amiss
  std::size_t replicates = 0;  ///< answers to different seeds that it is the mean of
  std::uint32_t samples_each = 0;
  double seconds = 0;  ///< that making it took, pilots and all
};

/// Below this there is nothing to win: a tenth of the smallest error that is recommended for.
inline constexpr double kGoodReference = 1e-4;
/// Fewer tell no error.
inline constexpr std::size_t kFewestReplicates = 4;

/// Seconds on a clock that only goes forward.
using Clock = std::function<double()>;

/// The chance that a closed form or a way that is right is refused, by luck of what it is compared
/// with.
inline constexpr double kRefusal = 1e-3;

/// Takes the way of `question` that promises most for its time by two answers each, and then the
/// mean of as many answers to different seeds as fit into `seconds`, or as make it kGoodReference.
/// DEADLINE_EXCEEDED, telling how long it would take, where kFewestReplicates do not fit.
///
/// Where that way is to be checked, a part of the time goes to the best of the others: if the mean
/// of all values, each over its reference, differs by more than Student's interval, its answers are
/// the reference, and it warns.
///
/// Where automatic knows all in closed form, that is the reference, without an error of its own, if
/// every value lies within Student's interval of what was sampled; else that stays, and warns.
absl::StatusOr<Reference> make_reference(const Question& question, double seconds,
                                         std::uint64_t seed, const Clock& clock);

/// Different for each pair of numbers, with the bits of splitmix64.  [Steele14]
std::uint64_t mixed_seed(std::uint64_t seed, std::uint64_t number);

}  // namespace lucerna::tradeoff
