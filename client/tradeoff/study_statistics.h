// Statistics of repeated measurements: intervals, quartiles, curves of error against time.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace lucerna::tradeoff {

/// A median and its quartiles, in any unit.
struct Quartiles {
  double lower = 0;
  double median = 0;
  double upper = 0;
};

/// Quantiles 1/4, 1/2 and 3/4 of at least one number, by linear interpolation between the sorted
/// numbers.  The first number is quantile 0, the last one quantile 1.  [Hyndman96, definition 7]
Quartiles quartiles(std::vector<double> numbers);

/// A mean and its 95% confidence interval.
struct Interval {
  double mean = 0;
  double lower = 0;
  double upper = 0;
};

/// Student's interval of the mean of at least one number >= 0.  It is computed for the logarithm by
/// the delta method, mean exp(-+ t s / (sqrt(n) mean)), so that it stays above 0.  A single number
/// gives [0, infinity); numbers that are all 0 give [0, 0].
Interval mean_interval(std::span<const double> numbers);
/// The interval of the root of the mean of squares, for errors.
Interval root_mean_interval(std::span<const double> squares);

/// One amount of work of one setting.
struct Measured {
  double seconds = 0;  ///< > 0
  double error = 0;    ///< >= 0
  double samples = 0;  ///< > 0; with target errors, a number in proportion to the samples
};

/// Where a curve reaches an error.
struct Reached {
  enum class How {
    kBetween,       ///< between two measurements
    kWithFewest,    ///< at the fastest measurement; nothing smaller was measured
    kExtrapolated,  ///< after the last measurement, at the rate of independent samples
  };
  How how = How::kBetween;
  double seconds = 0;
  double samples = 0;
};

/// The rate b of error ~ seconds^b, by least squares in logarithms.  Empty for fewer than two
/// different times, or if an error is 0.
std::optional<double> fitted_rate(std::span<const Measured> curve);

/// The time at which a setting reaches `error` > 0.  Interpolates linearly in logarithms before the
/// first measurement (by time) that has at most this error.  After the last measurement,
/// extrapolates with the rate kRate of independent samples, up to kFarthest times the last time.  A
/// rate fitted to few points would be unreliable.  Empty if the error is not reached, or if the
/// last three errors fall more slowly than kSlowestRate.
std::optional<Reached> time_to_error(std::vector<Measured> curve, double error,
                                     bool extrapolate = true);

/// Rates of error with time.  Independent samples have -0.5, and biased answers approach 0.
inline constexpr double kRate = -0.5, kSlowestRate = -0.35;
/// Longest extrapolation, as a multiple of the last time: two decades of error at kRate.
inline constexpr double kFarthest = 1e4;

/// The indices of the points that no other point beats in both time and error, in order of time.
/// Of equal points, only the first.
std::vector<std::size_t> pareto_front(std::span<const Measured> points);

}  // namespace lucerna::tradeoff
