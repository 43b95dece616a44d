#include "client/lab/verify_statistics.h"

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numeric>

#include "proto/common/confidence.h"

namespace lucerna::verify {
namespace {

// A cell must have this many effective samples, so that the chi-square distribution holds far out
// in its tail.
constexpr double kFewestInCell = 12;
// Fewer effective samples say nothing of a mean.
constexpr double kFewestOfMean = 30;

}  // namespace

TestResult cells_have_probabilities(const Partition& partition,
                                    const std::vector<std::size_t>& cells,
                                    const std::vector<double>& weights, double reference) {
  struct Cell {
    double sum = 0, squares = 0, probability = 0;
    std::size_t id = 0;
  };
  const auto n = static_cast<double>(weights.size());
  std::vector<Cell> all(partition.cells());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].probability = partition.probabilities()[i];
    all[i].id = i;
  }
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    all[cells[i]].sum += weights[i];
    all[cells[i]].squares += weights[i] * weights[i];
    sum += weights[i];
    squares += weights[i] * weights[i];
  }
  TestResult result;
  if (!(squares > 0)) return result;
  // The expected number of effective samples decides which cells are joined.  It uses the spread of
  // the weights inside of each cell, but not the number of samples in it: that would favour cells
  // with many samples.
  const double mean_weight = squares / sum;
  const auto spread = [&](const Cell& c) { return c.sum > 0 ? c.squares / c.sum : mean_weight; };
  const auto effective = [&](const Cell& c) { return sum * c.probability / spread(c); };
  std::vector<Cell> joined;
  for (const Cell& c : all) {
    if (!joined.empty() && effective(joined.back()) < kFewestInCell) {
      Cell& last = joined.back();
      last.sum += c.sum;
      last.squares += c.squares;
      last.probability += c.probability;
    } else {
      joined.push_back(c);
    }
  }
  while (joined.size() > 1 && effective(joined.back()) < kFewestInCell) {
    Cell& before = joined[joined.size() - 2];
    before.sum += joined.back().sum;
    before.squares += joined.back().squares;
    before.probability += joined.back().probability;
    joined.pop_back();
  }
  result.cells = joined.size();
  if (joined.size() < 2) return result;
  // The variance of a cell's mean weight is that of a sum over a Poisson number of samples.  Its
  // expectation under the null is used, as in Pearson's test.
  double factor = sum / n;
  const auto variance = [&](const Cell& c) {
    return factor * c.probability * spread(c) / n +
           factor * factor * c.probability / std::max(1.0, reference);
  };
  double upper = 0, lower = 0;
  for (const Cell& c : joined) {
    upper += c.sum / n * c.probability / variance(c);
    lower += c.probability * c.probability / variance(c);
  }
  factor = upper / lower;
  double statistic = 0, worst = 0;
  for (const Cell& c : joined) {
    const double difference = c.sum / n - factor * c.probability;
    const double term = difference * difference / variance(c);
    statistic += term;
    if (term > worst) {
      worst = term;
      result.worst_cell = c.id;
      result.worst_ratio = c.sum / n / (factor * c.probability);
    }
  }
  result.p = boost::math::gamma_q(static_cast<double>(joined.size() - 1) / 2, statistic / 2);
  return result;
}

MeanResult mean_is(const std::vector<double>& values, double expected, double tolerance,
                   double expected_error) {
  MeanResult result;
  const auto n = static_cast<double>(values.size());
  if (values.empty()) return result;
  result.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double second = 0, third = 0, squares = 0;
  for (const double v : values) {
    const double d = v - result.mean;
    second += d * d;
    third += d * d * d;
    squares += v * v;
  }
  if (n > 1) result.standard_error = std::hypot(std::sqrt(second / (n - 1) / n), expected_error);
  const double sum = n * result.mean;
  if (n < 2 || !(squares > 0) || sum * sum / squares < kFewestOfMean) return result;
  const double difference = result.mean - expected;
  const double beyond = std::max(0.0, std::fabs(difference) - tolerance);
  if (beyond == 0) {
    result.p = 1;
    return result;
  }
  // Rounding leaves a scatter of its own in values that are all equal.
  if (result.standard_error < 1e-12 * std::fabs(expected)) {
    result.p = 0;
    return result;
  }
  const double t = std::copysign(beyond / result.standard_error, difference);
  const double skewness = second > 0 ? third / n / std::pow(second / n, 1.5) : 0;
  // Hall's cubic is monotone, unlike the plain expansion.
  const double a = skewness / std::sqrt(n);
  const double corrected = t + a * t * t / 3 + a * a * t * t * t / 27 + a / 6;
  // The correction may only widen.
  const double freedom = sum * sum / squares - 1;
  const double plain = student_p(t, freedom);
  result.p = t * corrected <= 0 ? 1.0 : std::max(plain, student_p(corrected, freedom));
  return result;
}

std::vector<double> holm(const std::vector<double>& p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
  std::vector<double> adjusted(p.size());
  double least = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    least = std::max(least, std::min(1.0, static_cast<double>(p.size() - i) * p[order[i]]));
    adjusted[order[i]] = least;
  }
  return adjusted;
}

}  // namespace lucerna::verify
