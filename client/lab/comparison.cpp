#include "client/lab/comparison.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "proto/common/quantile.h"

namespace lucerna::verify {

namespace {

/// Two directions at right angles to each.
std::vector<std::pair<Double3, Double3>> tangents(const std::vector<Double3>& directions) {
  std::vector<std::pair<Double3, Double3>> result;
  for (const Double3& w : directions) {
    const Double3 other = std::fabs(w[0]) < 0.7 ? Double3{1, 0, 0} : Double3{0, 1, 0};
    const Double3 a = normalized(cross(w, other));
    result.emplace_back(a, cross(w, a));
  }
  return result;
}

}  // namespace

std::vector<Range> ranges_of(
    const std::vector<Double3>& directions, double angle_rad,
    const std::function<std::vector<double>(const std::vector<Double3>&)>& numbers) {
  // Beside an edge, numbers rise up to the edge and are 0 behind it.  So smaller angles count too.
  constexpr double kShares[] = {1, 0.1, 0.01};
  const auto around = tangents(directions);
  std::vector<Range> ranges(directions.size(), {std::numeric_limits<double>::infinity(), 0});
  const auto add = [&](const std::vector<Double3>& moved) {
    const std::vector<double> all = numbers(moved);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (std::isnan(all[i])) continue;
      ranges[i].lower = std::min(ranges[i].lower, all[i]);
      ranges[i].upper = std::max(ranges[i].upper, all[i]);
    }
  };
  add(directions);
  for (const double share : kShares) {
    for (const double step : {share * angle_rad, -share * angle_rad}) {
      for (const bool first : {true, false}) {
        std::vector<Double3> moved = directions;
        for (std::size_t i = 0; i < moved.size(); ++i)
          moved[i] = normalized(moved[i] + step * (first ? around[i].first : around[i].second));
        add(moved);
      }
    }
  }
  return ranges;
}

double relative_error(double theirs, const Range& ours) {
  if (theirs >= ours.lower && theirs <= ours.upper) return 0;
  const double nearest = theirs < ours.lower ? ours.lower : ours.upper;
  if (nearest == 0 || theirs == 0) return std::numeric_limits<double>::infinity();
  return std::fabs(theirs / nearest - 1);
}

void compare(const std::vector<double>& theirs, const std::vector<double>& ours,
             const std::function<std::vector<Range>(const std::vector<std::size_t>&)>& rounded,
             const std::function<std::string(std::size_t)>& place, const Strictness& strictness,
             Finding* finding) {
  std::vector<std::size_t> rows, suspects;
  std::vector<double> errors;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (std::isnan(ours[i]) || std::isnan(theirs[i])) continue;
    rows.push_back(i);
    errors.push_back(relative_error(theirs[i], {ours[i], ours[i]}));
    if (errors.back() > strictness.tolerance) suspects.push_back(rows.size() - 1);
  }
  finding->rows = rows.size();
  finding->left_out = theirs.size() - rows.size();
  if (rows.empty()) return;
  if (rounded && !suspects.empty()) {
    const std::vector<Range> ranges = rounded(at_rows(rows, suspects));
    for (std::size_t i = 0; i < suspects.size(); ++i) {
      double& error = errors[suspects[i]];
      error = std::min(error, relative_error(theirs[rows[suspects[i]]], ranges[i]));
    }
  }
  finding->median = median(errors);
  const auto worst = std::ranges::max_element(errors);
  finding->worst = *worst;
  finding->off = static_cast<std::size_t>(
      std::ranges::count_if(errors, [&](double e) { return e > strictness.tolerance; }));
  if (finding->off > 0) {
    const std::size_t row = rows[static_cast<std::size_t>(worst - errors.begin())];
    finding->where = fmt::format("{}: {:.6g}, Lucerna: {:.6g}", place(row), theirs[row], ours[row]);
  }
  // In few rows, one may be beside an edge.
  constexpr std::size_t kFewRows = 50;
  const double allowed = std::max(rows.size() >= kFewRows ? 1.0 : 0.0,
                                  strictness.outliers * static_cast<double>(rows.size()));
  const bool differs = static_cast<double>(finding->off) > allowed;
  finding->verdict = differs ? Verdict::kDiffers : Verdict::kAgrees;
}

std::vector<std::size_t> some_rows(std::size_t n, std::size_t most) {
  std::vector<std::size_t> rows;
  const std::size_t count = std::min(n, most);
  for (std::size_t i = 0; i < count; ++i) rows.push_back(i * n / count);
  return rows;
}

std::string text(const Double3& v) { return fmt::format("{:.4g} {:.4g} {:.4g}", v[0], v[1], v[2]); }

}  // namespace lucerna::verify
