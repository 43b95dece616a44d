#include "client/tradeoff/analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/terminal/certainty.h"

namespace lucerna::tradeoff {
namespace {

// Errors below this multiple of the reference's own error are not resolved, since they are small
// differences of larger numbers.
constexpr double kResolved = 0.5;

double median(std::vector<double> numbers) { return quartiles(std::move(numbers)).median; }

/// An error without the reference's own error.  The reference has independent samples, so the
/// squares of both errors add.  The result is at least a quarter of the least resolved error.
Interval without(double reference_error, const Interval& e) {
  const auto rest = [&](double error) {
    const double least = kResolved / 4 * reference_error;
    return std::sqrt(std::fmax(error * error - reference_error * reference_error, least * least));
  };
  return {.mean = rest(e.mean), .lower = rest(e.lower), .upper = rest(e.upper)};
}

std::vector<Cell> cells_of(std::size_t setting, const std::vector<Run>& runs,
                           const Reference& reference) {
  std::vector<Cell> cells;
  for (const Run& run : runs) {
    if (run.setting != setting || run.round == 0) continue;
    if (std::none_of(cells.begin(), cells.end(),
                     [&](const Cell& c) { return c.amount == run.amount; }))
      cells.emplace_back().amount = run.amount;
  }
  for (Cell& cell : cells) {
    std::vector<double> seconds, relative, squares, flips, samples, rays;
    for (const Run& run : runs) {
      if (run.setting != setting || run.round == 0 || !(run.amount == cell.amount)) continue;
      seconds.push_back(run.seconds);
      relative.push_back(run.errors.relative_mse);
      squares.push_back(run.errors.rmse * run.errors.rmse);
      if (run.errors.flip) flips.push_back(*run.errors.flip);
      samples.push_back(run.samples);
      rays.push_back(run.rays);
    }
    cell.runs = seconds.size();
    cell.seconds = quartiles(seconds);
    cell.error = root_mean_interval(relative);
    cell.rmse = root_mean_interval(squares);
    if (!reference.exact) {
      cell.error = without(reference.relative_error, cell.error);
      cell.rmse = without(reference.rmse, cell.rmse);
    }
    if (!flips.empty()) cell.flip = mean_interval(flips);
    cell.samples = median(samples);
    cell.rays = median(rays);
  }
  // All amounts must be exact, because a setting that is not exact may come as near with many
  // samples.
  const bool exact = reference.relative_error <= kRounding &&
                     std::all_of(cells.begin(), cells.end(),
                                 [](const Cell& cell) { return cell.error.mean <= kRounding; });
  for (Cell& cell : cells) {
    cell.exact = exact;
    if (exact) cell.error = {};
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.amount.target ? a.amount.value > b.amount.value : a.amount.value < b.amount.value;
  });
  return cells;
}

void judge_efficiency(Curve& curve, double reference_error) {
  // Take the largest amount whose error is resolved, or else the least amount.
  for (std::size_t k = curve.cells.size(); k-- > 0;) {
    const Interval& e = curve.cells[k].error;
    if (e.mean <= 0 || (k > 0 && e.mean < kResolved * reference_error)) continue;
    const double t = curve.cells[k].seconds.median;
    curve.efficient_at = k;
    curve.efficiency = Interval{.mean = 1 / (e.mean * e.mean * t),
                                .lower = 1 / (e.upper * e.upper * t),
                                .upper = 1 / (e.lower * e.lower * t)};
    return;
  }
}

double counted(const Reached& reached) {
  return reached.seconds * (reached.how == Reached::How::kExtrapolated ? kExtrapolatedCounts : 1);
}

/// A number in proportion to the samples of an amount; amount_value() is the inverse.  The samples
/// of a target error grow with the inverse of its square.
double proportional_samples(const Amount& amount) {
  return amount.target ? 1 / (amount.value * amount.value) : amount.value;
}
double amount_value(bool by_target, double samples) {
  return by_target ? 1 / std::sqrt(samples) : samples;
}

/// Medians of times and means of errors.  With `late`, upper quartiles of times and upper ends of
/// the errors' intervals.
std::vector<Measured> measured(const std::vector<Cell>& cells, bool late) {
  std::vector<Measured> result;
  for (const Cell& cell : cells) {
    if (late && !std::isfinite(cell.error.upper)) continue;
    result.push_back({.seconds = late ? cell.seconds.upper : cell.seconds.median,
                      .error = late ? cell.error.upper : cell.error.mean,
                      .samples = proportional_samples(cell.amount)});
  }
  return result;
}

/// When a setting with these cells reaches `error`, and with which amount.  Errors that are not
/// resolved are extrapolated from resolved ones.  Approximations are never extrapolated, because
/// more samples do not make their errors smaller.
std::optional<Reached> reach(std::vector<Measured> curve, double error, const Setting& setting,
                             const Reference& reference) {
  const double resolved = reference.exact ? 0 : kResolved * reference.relative_error;
  if (error < resolved) std::erase_if(curve, [&](const Measured& m) { return m.error < resolved; });
  auto reached = time_to_error(std::move(curve), error, !cli::is_approximate(setting.accuracy));
  if (reached) reached->samples = amount_value(setting.by_target, reached->samples);
  return reached;
}

Recommendation recommend(std::size_t level, const std::vector<Setting>& settings,
                         const std::vector<Curve>& curves, const Reference& reference) {
  Recommendation r;
  r.error = kLevels[level];
  for (const Curve& curve : curves) {
    const auto& reached = curve.levels[level];
    if (!reached || (r.setting && counted(*reached) >= counted(r.best_reached))) continue;
    r.setting = r.best = curve.setting;
    r.best_reached = *reached;
  }
  if (!r.setting) {
    r.below_reference = !reference.exact && r.error < kResolved * reference.relative_error;
    return r;
  }
  // Prefer the simplest command: automatic by samples, then automatic by target error.
  const double latest = curves[r.best].latest[level].value_or(counted(r.best_reached));
  for (const Curve& curve : curves) {
    const auto& reached = curve.levels[level];
    if (!settings[curve.setting].flags.empty() || !reached) continue;
    if (curve.setting != r.best && counted(*reached) > latest) continue;
    r.setting = curve.setting;
    break;
  }
  const Curve& chosen = curves[*r.setting];
  r.reached = *chosen.levels[level];
  r.exact = chosen.exact().has_value();
  if (r.exact) {
    const Cell& cell = chosen.cells[*chosen.exact()];
    r.reached.seconds = cell.seconds.median;
    r.reached.samples = cell.amount.value;
  }
  r.amount = practical(settings[*r.setting].by_target, r.reached.samples);
  if (const auto& automatic = curves[0].levels[level]) {
    r.automatic_ratio = automatic->seconds / r.best_reached.seconds;
    r.automatic_extrapolated = automatic->how == Reached::How::kExtrapolated;
  }
  return r;
}

void compare(const std::vector<Setting>& settings, Analysis& a) {
  // Compare at a time that every remaining setting reached.  Exact settings have no errors to
  // compare.
  double least = std::numeric_limits<double>::infinity();
  for (const Curve& curve : a.curves)
    if (!curve.cells.empty() && !curve.cells.back().exact)
      least = std::min(least, curve.cells.back().seconds.median);
  a.comparison_s = std::isinf(least) ? 0 : least;
  a.compared.resize(settings.size());
  if (a.comparison_s == 0) return;
  for (std::size_t i = 0; i < a.curves.size(); ++i) {
    double nearest = std::log(kAboutTheSame);
    for (std::size_t k = 0; k < a.curves[i].cells.size(); ++k) {
      const Cell& cell = a.curves[i].cells[k];
      const double distance = std::fabs(std::log(cell.seconds.median / a.comparison_s));
      if (cell.exact || distance > nearest) continue;
      nearest = distance;
      a.compared[i] = k;
    }
  }
}

}  // namespace

std::optional<std::size_t> Curve::exact() const {
  std::optional<std::size_t> fastest;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (!cells[k].exact) continue;
    if (cells.size() > 1 && !cells[k].amount.target && cells[k].amount.value < 2) continue;
    if (!fastest || cells[k].seconds.median < cells[*fastest].seconds.median) fastest = k;
  }
  return fastest;
}

Amount practical(bool by_target, double value) {
  if (by_target) {
    const double digit = std::pow(10, std::floor(std::log10(value)) - 1);
    // The addend cancels the rounding of numbers that have two digits already.
    return {.target = true, .value = std::floor(value / digit + 1e-9) * digit};
  }
  const double whole = std::ceil(value - 1e-9);
  return {.target = false, .value = whole > 16 ? 16 * std::ceil(whole / 16) : whole};
}

Analysis analyse(const std::vector<Setting>& settings, const SweepResult& sweep,
                 const Reference& reference) {
  Analysis a;
  std::vector<Measured> all;
  std::vector<std::pair<std::size_t, std::size_t>> places;
  double least_error = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < settings.size(); ++i) {
    Curve curve;
    curve.setting = i;
    curve.cells = cells_of(i, sweep.runs, reference);
    const std::vector<Measured> middle = measured(curve.cells, false),
                                late = measured(curve.cells, true);
    curve.rate = middle.size() < 2
                     ? std::nullopt
                     : fitted_rate(std::span(middle).last(std::min<std::size_t>(3, middle.size())));
    judge_efficiency(curve, reference.relative_error);
    for (std::size_t level = 0; level < kLevels.size(); ++level) {
      curve.levels[level] = reach(middle, kLevels[level], settings[i], reference);
      if (const auto reached = reach(late, kLevels[level], settings[i], reference))
        curve.latest[level] = counted(*reached);
    }
    for (std::size_t k = 0; k < middle.size(); ++k) {
      all.push_back(middle[k]);
      places.emplace_back(i, k);
      if (!curve.cells[k].exact) least_error = std::min(least_error, middle[k].error);
    }
    a.curves.push_back(std::move(curve));
  }
  for (const std::size_t i : pareto_front(all)) a.front.push_back(places[i]);
  for (std::size_t level = 0; level < kLevels.size(); ++level)
    a.levels[level] = recommend(level, settings, a.curves, reference);
  compare(settings, a);
  if (!reference.warning.empty()) a.warnings.push_back(reference.warning);
  if (reference.relative_error > kRounding && !reference.exact &&
      reference.relative_error * kReferenceMargin > least_error) {
    a.warnings.push_back(fmt::format(
        "The reference's own error, {:.3g}%, is not {:g} times below the best setting's, {:.3g}%. "
        "Small errors are therefore uncertain. A larger --budget makes the reference better.",
        100 * reference.relative_error, kReferenceMargin, 100 * least_error));
  }
  return a;
}

}  // namespace lucerna::tradeoff
