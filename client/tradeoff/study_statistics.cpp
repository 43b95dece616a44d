#include "client/tradeoff/study_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "proto/common/confidence.h"

namespace lucerna::tradeoff {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double interpolated(const std::vector<double>& sorted, double p) {
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], at - static_cast<double>(below));
}

void sort_by_time(std::vector<Measured>& curve) {
  std::stable_sort(curve.begin(), curve.end(),
                   [](const Measured& a, const Measured& b) { return a.seconds < b.seconds; });
}

/// The point at share `t` of the way from a to b in logarithms.  With t > 1 it is after b.
Reached along(const Measured& a, const Measured& b, double t, Reached::How how) {
  return {.how = how,
          .seconds = a.seconds * std::pow(b.seconds / a.seconds, t),
          .samples = a.samples * std::pow(b.samples / a.samples, t)};
}

}  // namespace

Quartiles quartiles(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  return {.lower = interpolated(numbers, 0.25),
          .median = interpolated(numbers, 0.5),
          .upper = interpolated(numbers, 0.75)};
}

Interval mean_interval(std::span<const double> numbers) {
  const auto n = static_cast<double>(numbers.size());
  const double mean = std::accumulate(numbers.begin(), numbers.end(), 0.0) / n;
  if (numbers.size() < 2) return {.mean = mean, .lower = 0, .upper = kInfinity};
  double squares = 0;
  for (const double x : numbers) squares += (x - mean) * (x - mean);
  if (squares == 0) return {.mean = mean, .lower = mean, .upper = mean};
  const double standard_error = std::sqrt(squares / (n - 1) / n);
  const double t = student_quantile(n - 1, 0.025);
  const double factor = std::exp(t * standard_error / mean);
  return {.mean = mean, .lower = mean / factor, .upper = mean * factor};
}

Interval root_mean_interval(std::span<const double> squares) {
  const Interval of = mean_interval(squares);
  return {.mean = std::sqrt(of.mean), .lower = std::sqrt(of.lower), .upper = std::sqrt(of.upper)};
}

std::optional<double> fitted_rate(std::span<const Measured> curve) {
  double x = 0, y = 0;
  for (const Measured& m : curve) {
    if (m.error <= 0) return std::nullopt;
    x += std::log(m.seconds) / static_cast<double>(curve.size());
    y += std::log(m.error) / static_cast<double>(curve.size());
  }
  double xx = 0, xy = 0;
  for (const Measured& m : curve) {
    xx += (std::log(m.seconds) - x) * (std::log(m.seconds) - x);
    xy += (std::log(m.seconds) - x) * (std::log(m.error) - y);
  }
  if (xx == 0) return std::nullopt;
  return xy / xx;
}

std::optional<Reached> time_to_error(std::vector<Measured> curve, double error, bool extrapolate) {
  if (curve.empty()) return std::nullopt;
  sort_by_time(curve);
  if (curve[0].error <= error) {
    return Reached{
        .how = Reached::How::kWithFewest, .seconds = curve[0].seconds, .samples = curve[0].samples};
  }
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const Measured &a = curve[i - 1], &b = curve[i];
    if (b.error > error) continue;
    // An exact answer has no logarithm.
    if (b.error == 0) return along(a, b, 1, Reached::How::kBetween);
    return along(a, b, std::log(a.error / error) / std::log(a.error / b.error),
                 Reached::How::kBetween);
  }
  if (!extrapolate || curve.size() < 2) return std::nullopt;
  const std::span<const Measured> tail =
      std::span(curve).last(std::min<std::size_t>(3, curve.size()));
  const auto rate = fitted_rate(tail);
  if (!rate || *rate > kSlowestRate) return std::nullopt;
  const Measured& last = curve.back();
  const double factor = std::pow(error / last.error, 1 / kRate);
  if (factor > kFarthest) return std::nullopt;
  // The samples follow from the errors alone.  Times of a noisy machine say too little about them.
  return Reached{.how = Reached::How::kExtrapolated,
                 .seconds = last.seconds * factor,
                 .samples = last.samples * factor};
}

std::vector<std::size_t> pareto_front(std::span<const Measured> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a].seconds != points[b].seconds ? points[a].seconds < points[b].seconds
                                                  : points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  double best = kInfinity;
  for (const std::size_t i : order) {
    if (points[i].error >= best) continue;
    best = points[i].error;
    front.push_back(i);
  }
  return front;
}

}  // namespace lucerna::tradeoff
