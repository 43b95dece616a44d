// How many samples an estimate needs for a target error.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "server/estimate/statistics/confidence.h"

namespace lucerna {

/// Blocks of independent points.
struct Blocks {
  std::uint64_t first, count;
  std::uint32_t samples;  ///< of each
};

/// What a pilot says.
struct PilotEstimate {
  double value = 0;
  /// Of as many samples as the pilot has, in the replicates of an answer.
  Interval interval;
  /// Intervals of fewer samples would hold less often than they say.
  double least_samples = 0;
};

/// Of the first pilot.
inline constexpr std::uint64_t kFirstPilotSamples = 64;

/// How many samples an estimate needs for `target`, at least 1 and at most its max_samples; nothing
/// where `pilot` was stopped.  `pilot(blocks)` takes the samples of these blocks alone and returns
/// an optional PilotEstimate of them.
///
/// They are found from samples of their own, which are then left out: a count that depends on the
/// samples it counts would make their mean biased. [Kirk91]
///
/// A pilot of more than a quarter of max_samples is not taken: where none smaller suffices, and
/// with a max_samples of less than 256 always, the answer is max_samples.  Those may be more than
/// needed, but are a count that no sample decided about: their mean and interval hold as of any
/// count.
template <typename Pilot>
std::optional<double> needed_samples(const TargetError& target, Pilot&& pilot) {
  // No answer has so many blocks.
  constexpr std::uint64_t kFirstBlock = std::uint64_t{1} << 32;
  // As many as of an answer, or twice as many: where they scatter less by luck, too few samples are
  // taken.
  constexpr std::uint32_t kBlockCount = 32;
  constexpr std::uint32_t kFirst = kFirstPilotSamples / kBlockCount;  // samples a block
  // Pilots grow by this until no more than this many times their samples are needed: together they
  // take a third of those at most.
  constexpr std::uint32_t kGrowth = 4;
  // Where samples are skewed more are taken than their scatter asks for, up to this many times the
  // pilot's: with 4 times, 92.8% of the intervals of a furnace's pixels held instead of 95%.
  constexpr std::uint32_t kMostForShape = 8;
  // Where the pilot scatters less by luck, the answer has too few samples: without so many more,
  // 94.9% of the answers about a furnace were within 2% where that was asked for with 95%
  // confidence, with them 97.3% (coverage_test).
  constexpr double kForLuck = 1.25;
  const auto most = static_cast<double>(target.max_samples);
  for (std::uint64_t n = kFirst;; n *= kGrowth) {
    const std::uint64_t samples = n * kBlockCount;
    if (samples * kGrowth > target.max_samples) return most;
    const std::optional<PilotEstimate> e =
        pilot(Blocks{kFirstBlock, kBlockCount, static_cast<std::uint32_t>(n)});
    if (!e) return std::nullopt;
    const double allowed = std::max(target.relative * e->value, target.absolute_floor);
    const double error = (e->interval.upper - e->interval.lower) / 2;
    // By the rate of independent samples, which is the slowest.
    const double off = error / allowed, times = std::fmax(1, kForLuck * off * off);
    if (error <= allowed || times <= kGrowth)
      return std::min(
          most, std::max(static_cast<double>(samples) * times,
                         std::min(e->least_samples, static_cast<double>(samples) * kMostForShape)));
  }
}

}  // namespace lucerna
