// What runs say of settings.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/tradeoff/reference.h"
#include "client/tradeoff/statistics.h"
#include "client/tradeoff/sweep.h"

namespace lucerna::tradeoff {

/// What is recommended for: relative errors, root mean square over the items.
inline constexpr std::array<double, 3> kLevels = {0.1, 0.01, 0.001};

/// A reference that is not so many times better than the best setting is told to be the limit.
inline constexpr double kReferenceMargin = 3;

/// A time beyond what was measured counts so many times when settings are ranked: it grows with the
/// root of the time at best, and what was measured is known.
inline constexpr double kExtrapolatedCounts = 2;

/// Settings are compared item by item where they have an amount of a time within this factor.
inline constexpr double kAboutTheSame = 2;

/// All counted runs of one amount of one setting.
struct Cell {
  Amount amount;
  std::size_t runs = 0;
  /// As are all of its setting: the reference to rounding (kRounding), where that has no error of
  /// its own.  Then 0 is told.
  bool exact = false;
  Quartiles seconds;
  /// Relative: root of the mean over runs of the relative MSE, without the reference's own.
  Interval error;
  Interval rmse;
  std::optional<Interval> flip;
  double samples = 0, rays = 0;  ///< medians, over all items
};

struct Curve {
  std::size_t setting = 0;
  std::vector<Cell> cells;  ///< by amount; none where the setting was not swept
  std::optional<double> rate;
  /// 1 / (relative MSE x seconds) [1/s], at `efficient_at` of the cells.
  std::optional<Interval> efficiency;
  std::size_t efficient_at = 0;
  std::array<std::optional<Reached>, kLevels.size()> levels;
  /// When it comes down to them where errors are at the upper ends of their intervals and times at
  /// their upper quartiles [s].
  std::array<std::optional<double>, kLevels.size()> latest{};

  /// Of what is exact the cell that takes least time, of more than one sample where there is a
  /// choice: a single one tells no error, and so not that it is exact.
  std::optional<std::size_t> exact() const;
};

struct Recommendation {
  double error = 0;
  /// What to ask for: the best, or the simplest command that is not told apart from it.
  std::optional<std::size_t> setting;
  Reached reached;
  Amount amount;
  bool exact = false;
  /// Of least time, those beyond what was measured counted kExtrapolatedCounts times.
  std::size_t best = 0;
  Reached best_reached;
  /// Time of automatic over that of the best.
  std::optional<double> automatic_ratio;
  bool automatic_extrapolated = false;
  /// That no setting is told, as the reference does not tell errors so small.
  bool below_reference = false;
};

struct Analysis {
  std::vector<Curve> curves;  ///< one a setting
  /// (setting, cell), by time.
  std::vector<std::pair<std::size_t, std::size_t>> front;
  std::array<Recommendation, kLevels.size()> levels;
  /// The time at which settings are compared item by item, and the cell of each nearest to it.
  double comparison_s = 0;
  std::vector<std::optional<std::size_t>> compared;
  /// What a reader must know before believing it.
  std::vector<std::string> warnings;
};

Analysis analyse(const std::vector<Setting>& settings, const SweepResult& sweep,
                 const Reference& reference);

/// Whole samples upwards, of more than 16 a multiple of 16, as replicates are; target errors
/// downwards to two digits.
Amount practical(bool by_target, double value);

}  // namespace lucerna::tradeoff
