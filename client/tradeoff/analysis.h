// Error against time of each setting, and the recommendations, from the runs of a sweep.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/tradeoff/reference.h"
#include "client/tradeoff/study_statistics.h"
#include "client/tradeoff/sweep.h"

namespace lucerna::tradeoff {

/// The study recommends a setting for each of these relative errors, which are root mean squares
/// over the items.
inline constexpr std::array<double, 3> kLevels = {0.1, 0.01, 0.001};

/// The analysis warns if the best setting's error is less than this multiple of the reference's own
/// error.
inline constexpr double kReferenceMargin = 3;

/// Extrapolated times are multiplied by this when settings are ranked, because errors fall with the
/// root of the time at best.
inline constexpr double kExtrapolatedCounts = 2;

/// Settings are compared item by item if they have an amount whose time is within this factor.
inline constexpr double kAboutTheSame = 2;

/// All counted runs of one amount of one setting.
struct Cell {
  Amount amount;
  std::size_t runs = 0;
  /// The setting is exact: all its cells equal a reference without error, up to kRounding.  The
  /// error is then 0.
  bool exact = false;
  Quartiles seconds;
  /// Relative error: the root of the mean over runs of the relative MSE, without the reference's
  /// own error.
  Interval error;
  Interval rmse;
  std::optional<Interval> flip;
  double samples = 0, rays = 0;  ///< medians, over all items
};

struct Curve {
  std::size_t setting = 0;
  std::vector<Cell> cells;  ///< in order of amount; empty if the setting was not swept
  std::optional<double> rate;
  /// 1 / (relative MSE x seconds) [1/s], at the cell `efficient_at`.
  std::optional<Interval> efficiency;
  std::size_t efficient_at = 0;
  std::array<std::optional<Reached>, kLevels.size()> levels;
  /// The times [s] at which the setting reaches kLevels, from the upper ends of the errors'
  /// intervals and the upper quartiles of the times.
  std::array<std::optional<double>, kLevels.size()> latest{};

  /// The fastest exact cell.  Prefers cells of more than one sample, because a single sample does
  /// not show that it is exact.
  std::optional<std::size_t> exact() const;
};

struct Recommendation {
  double error = 0;
  /// The best setting, or the simplest one that is not significantly slower.
  std::optional<std::size_t> setting;
  Reached reached;
  Amount amount;
  bool exact = false;
  /// The setting of least time.  Extrapolated times are multiplied by kExtrapolatedCounts.
  std::size_t best = 0;
  Reached best_reached;
  /// The time of automatic divided by the time of the best setting.
  std::optional<double> automatic_ratio;
  bool automatic_extrapolated = false;
  /// No setting is recommended, because the error is below the reference's own error.
  bool below_reference = false;
};

struct Analysis {
  std::vector<Curve> curves;  ///< one for each setting
  /// The Pareto front as (setting, cell), by time.
  std::vector<std::pair<std::size_t, std::size_t>> front;
  std::array<Recommendation, kLevels.size()> levels;
  /// The time [s] at which settings are compared item by item, and the nearest cell of each
  /// setting.
  double comparison_s = 0;
  std::vector<std::optional<std::size_t>> compared;
  /// Reasons to doubt the results, in words.
  std::vector<std::string> warnings;
};

Analysis analyse(const std::vector<Setting>& settings, const SweepResult& sweep,
                 const Reference& reference);

/// Rounds samples up to a whole number, above 16 to a multiple of 16, the number of replicates.
/// Rounds target errors down to two digits.
Amount practical(bool by_target, double value);

}  // namespace lucerna::tradeoff
