// What is made of repeated measurements: intervals, quartiles, curves of error against time.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace lucerna::tradeoff {

/// A median between its quartiles, of whatever unit.
struct Quartiles {
  double lower = 0;
  double median = 0;
  double upper = 0;
};

/// Of at least one number: quantiles 1/4, 1/2 and 3/4 by linear interpolation between the sorted
/// numbers, the first at 0 and the last at 1.  [Hyndman96, definition 7]
Quartiles quartiles(std::vector<double> numbers);

/// A mean and the 95% confidence interval about it.
struct Interval {
  double mean = 0;
  double lower = 0;
  double upper = 0;
};

/// Of numbers that are at least 0, at least one: Student's interval of their mean, taken to the
/// logarithm by the delta method, mean exp(-+ t s / (sqrt(n) mean)), so that it is above 0 as they
/// are.  A single number gives [0, infinity), numbers that are all 0 give [0, 0].
Interval mean_interval(std::span<const double> numbers);
/// The same of the root of the mean: for errors, whose squares are what is averaged.
Interval root_mean_interval(std::span<const double> squares);

/// One amount of work of one setting.
struct Measured {
  double seconds = 0;  ///< > 0
  double error = 0;    ///< >= 0
  double samples = 0;  ///< > 0, or a target error
};

/// Where a curve comes down to an error.
struct Reached {
  enum class How {
    kBetween,       ///< between two measurements
    kWithFewest,    ///< the fastest measurement is that good already: no less was tried
    kExtrapolated,  ///< beyond the last one, by the rate of independent samples
  };
  How how = How::kBetween;
  double seconds = 0;
  double samples = 0;
};

/// The rate b of error ~ seconds^b by least squares in logarithms; nothing for fewer than two
/// different times, or where an error is 0.
std::optional<double> fitted_rate(std::span<const Measured> curve);

/// When a setting's error is `error` > 0, linearly in logarithms between the first two neighbours
/// (by time) of which the later one is that good; beyond the last as errors of independent
/// samples fall, with the root of the time, up to kFarthest times its time: what few measurements
/// say of a rate would decide alone, so far from them.  Nothing where it never is, or where the
/// last three fall more slowly than kSlowestRate.
std::optional<Reached> time_to_error(std::vector<Measured> curve, double error,
                                     bool extrapolate = true);

/// Of error with time in logarithms: independent samples have -0.5, biased answers 0 in the end.
inline constexpr double kRate = -0.5, kSlowestRate = -0.35;
/// Two decades of error, by the rate of independent samples.
inline constexpr double kFarthest = 1e4;

/// Which of the points no other one beats in time and error both, in order of time.  Of equal ones
/// the first.
std::vector<std::size_t> pareto_front(std::span<const Measured> points);

}  // namespace lucerna::tradeoff
