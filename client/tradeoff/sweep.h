// Decides which settings are measured at which amounts, in which order, and for how long.
//
// A sweep consists of rounds.  Each round measures every cell (one amount of one setting) once.
// The order is random in each round, so that a drift of the machine affects all cells equally.  In
// a round all settings share one seed, so that common random numbers cancel from their differences.
//
// The first heat measures all settings.  Then the sweep drops settings that are far behind.  The
// second heat spends the rest of the time on the other settings, at larger amounts.  The caller
// supplies the answers and the clock, so the sweep contacts no server itself.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/tradeoff/reference.h"
#include "client/tradeoff/settings.h"
#include "client/tradeoff/study_errors.h"

namespace lucerna::tradeoff {

/// One question and its answer.
struct Run {
  std::size_t setting = 0;
  Amount amount{};
  /// From 1.  0 for runs that only measure the cost and do not count.
  std::uint32_t round = 0;
  std::uint64_t seed = 0;
  double seconds = 0;
  double samples = 0;
  double rays = 0;
  Errors errors{};
  /// Digest of the values.  Settings with equal digests count as one setting.
  std::uint64_t digest = 0;
};

struct SweepOptions {
  double seconds = 30;
  /// If above 0, the sweep ignores `seconds`, measures all amounts of all settings in this number
  /// of rounds, and drops no setting.
  std::uint32_t rounds = 0;
  std::uint64_t seed = 0;
  Clock clock{};
  /// Measures one question.  The sweep sets the run's setting, amount, round and seed.
  /// DEADLINE_EXCEEDED if the answer takes longer than `longest_s`.
  std::function<absl::StatusOr<Run>(std::size_t setting, const Amount& amount, std::uint64_t seed,
                                    std::uint32_t round, std::optional<double> longest_s)>
      answer{};
  /// Samples of the first question.  Its answers show which settings are the same.
  double first_samples = 4;
  /// Receives one line of progress.
  std::function<void(const std::string&)> on_event = [](const std::string&) {};
};

/// The course of a setting through the sweep.
struct Course {
  enum class Fate {
    kSwept,
    kSame,     ///< has the bits of the setting `same_as`
    kSkipped,  ///< the server refuses it, or it takes too long
    kDropped,  ///< was far behind after the first heat
  };
  Fate fate = Fate::kSwept;
  std::size_t same_as = 0;
  std::string why;  ///< the reason in words; empty for kSwept
};

struct SweepResult {
  std::vector<Run> runs;        ///< in the order of measurement
  std::vector<Course> courses;  ///< one for each setting
};

/// Each heat has at least this number of rounds.
inline constexpr std::uint32_t kFewestRounds = 3;
/// A setting is dropped if, at its largest amounts, it takes this many times the time of the best
/// setting for the same error.
inline constexpr double kFarBehind = 4;

/// Runs the sweep.  `ladders` has the amounts of each setting in increasing order of work.
/// DEADLINE_EXCEEDED, with the required time, if there is no time for the least amounts.  Errors of
/// the connection also end the sweep.
absl::StatusOr<SweepResult> sweep(const std::vector<Setting>& settings,
                                  const std::vector<std::vector<Amount>>& ladders,
                                  const SweepOptions& options);

}  // namespace lucerna::tradeoff
