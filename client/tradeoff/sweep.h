// Decides which settings are measured at which amounts, in which order, and for how long.
//
// The sweep goes in rounds.  Each round measures every cell (one amount of one setting) once, in a
// new random order, so that a drift of the machine affects all cells alike.  In a round all
// settings share one seed, so that common random numbers cancel from their differences.  The first
// heat measures all settings.  Then settings that are far behind leave, and the second heat spends
// the rest of the time on the others, at larger amounts.  The sweep contacts no server and reads no
// clock: the caller supplies both.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tradeoff/errors.h"
#include "client/tradeoff/reference.h"
#include "client/tradeoff/settings.h"

namespace lucerna::tradeoff {

/// One question and its answer.
struct Run {
  std::size_t setting = 0;
  Amount amount{};
  /// From 1; 0 for runs that only find out the cost and do not count.
  std::uint32_t round = 0;
  std::uint64_t seed = 0;
  double seconds = 0;
  double samples = 0;
  double rays = 0;
  Errors errors{};
  /// Of the values.  Settings of equal digests count as one setting.
  std::uint64_t digest = 0;
};

struct SweepOptions {
  double seconds = 30;
  /// If above 0, the sweep ignores `seconds`, measures all amounts of all settings in so many
  /// rounds, and drops no setting.
  std::uint32_t rounds = 0;
  std::uint64_t seed = 0;
  Clock clock{};
  /// Measures one question.  The sweep fills in setting, amount, round and seed of the run.
  /// DEADLINE_EXCEEDED if the answer takes longer than `longest_s`.
  std::function<absl::StatusOr<Run>(std::size_t setting, const Amount& amount, std::uint64_t seed,
                                    std::uint32_t round, std::optional<double> longest_s)>
      answer{};
  /// Samples of the first question, whose answers show which settings are the same.
  double first_samples = 4;
  /// Receives one line of progress.
  std::function<void(const std::string&)> on_event = [](const std::string&) {};
};

/// What happened to a setting.
struct Course {
  enum class Fate {
    kSwept,
    kSame,     ///< has the bits of the setting `same_as`
    kSkipped,  ///< the server refuses it, or it takes too long
    kDropped,  ///< was far behind after the first heat
  };
  Fate fate = Fate::kSwept;
  std::size_t same_as = 0;
  std::string why;  ///< in words; empty for kSwept
};

struct SweepResult {
  std::vector<Run> runs;        ///< in the order of measurement
  std::vector<Course> courses;  ///< one a setting
};

/// Each heat has at least so many rounds.
inline constexpr std::uint32_t kFewestRounds = 3;
/// A setting is dropped if, at its largest amounts, it takes so many times longer than the best
/// setting takes for the same error.
inline constexpr double kFarBehind = 4;

/// `ladders` holds the amounts of each setting, rising.  DEADLINE_EXCEEDED, with the time it needs,
/// if the least amounts do not fit.  Other errors of the connection end the sweep.
absl::StatusOr<SweepResult> sweep(const std::vector<Setting>& settings,
                                  const std::vector<std::vector<Amount>>& ladders,
                                  const SweepOptions& options);

}  // namespace lucerna::tradeoff
