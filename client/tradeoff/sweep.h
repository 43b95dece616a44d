// Which questions are asked in which order, for how long.
//
// Rounds: in each, every cell (an amount of a setting) that is still in the race is asked once, in
// an order shuffled anew, so that a machine that drifts hurts all alike, and with a seed that all
// settings share, so that luck that all have is no difference between them (common random numbers).
// The first heat is for all settings; settings that are far behind after it leave, and the second
// heat gives what is left of the time to the others, in larger amounts.  Knows no server and reads
// no clock: it is told both.
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
  /// 0: it was asked to learn what it costs, and does not count.
  std::uint32_t round = 0;
  std::uint64_t seed = 0;
  double seconds = 0;
  double samples = 0;
  double rays = 0;
  Errors errors{};
  /// Of the values: settings of equal bits are one setting.
  std::uint64_t digest = 0;
};

struct SweepOptions {
  double seconds = 30;
  std::uint64_t seed = 0;
  Clock clock{};
  /// Answers with the run, less what the sweep knows of it; DEADLINE_EXCEEDED where that would take
  /// longer than `longest_s`.
  std::function<absl::StatusOr<Run>(std::size_t setting, const Amount& amount, std::uint64_t seed,
                                    std::uint32_t round, std::optional<double> longest_s)>
      ask{};
  /// Of the question by which settings are told apart.
  double telling_samples = 4;
  /// What is told of the way.
  std::function<void(const std::string&)> on_event = [](const std::string&) {};
};

/// What became of a setting.
struct Course {
  enum class Fate {
    kSwept,
    kSame,     ///< same bits as the setting `same_as`
    kSkipped,  ///< the server has no answer, or it takes too long
    kDropped,  ///< after the first heat, far behind
  };
  Fate fate = Fate::kSwept;
  std::size_t same_as = 0;
  std::string why;  ///< in words, where not kSwept
};

struct SweepResult {
  std::vector<Run> runs;        ///< in the order asked
  std::vector<Course> courses;  ///< one a setting
};

/// Rounds that each heat has at least.
inline constexpr std::uint32_t kFewestRounds = 3;
/// A setting leaves whose largest amounts are so many times slower than the best at their errors.
inline constexpr double kFarBehind = 4;

/// `ladders` are the amounts of each setting, rising.  DEADLINE_EXCEEDED, telling how long it would
/// take, where not even the least amounts fit; what ends the connection ends the sweep.
absl::StatusOr<SweepResult> sweep(const std::vector<Setting>& settings,
                                  const std::vector<std::vector<Amount>>& ladders,
                                  const SweepOptions& options);

}  // namespace lucerna::tradeoff
