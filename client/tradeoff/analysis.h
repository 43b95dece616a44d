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

/// All counted runs of one amount of one setting.
struct Cell {
  Amount amount;
  std::size_t runs = 0;
  Quartiles seconds;
  Interval error;  ///< relative: root of the mean over runs of the relative MSE
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

  std::vector<Measured> measured() const;
};

struct Recommendation {
  double error = 0;
  std::optional<std::size_t> setting;
  Reached reached;
  Amount amount;
  /// Time of automatic over that of the setting.
  std::optional<double> automatic_ratio;
  bool automatic_extrapolated = false;
  bool below_reference = false;  ///< the reference does not tell errors so small
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
