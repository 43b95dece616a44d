// Measures the error of an answer against the reference.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lucerna::tradeoff {

/// The dark level as a share of the mean of the references.  Without a dark level, a nearly dark
/// item would dominate the relative error.
inline constexpr double kDark = 0.01;

/// Relative errors below this come from single precision of answers and of sums.  It is about ten
/// units in the last place.
inline constexpr double kRounding = 1e-6;

struct Errors {
  double rmse = 0;               ///< in the unit of the values
  double relative_mse = 0;       ///< mean of (value - reference)^2 / (reference^2 + dark^2)
  std::optional<double> flip{};  ///< mean FLIP of pictures, 0 to 1
};

/// kDark times the mean absolute value, without NaN.  1 if that is 0, so that it can be a divisor.
double dark_level(std::span<const double> reference);

/// Squared relative error of one value: (value - reference)^2 / (reference^2 + dark^2).
double relative_square(double value, double reference, double dark);

/// Measures the errors of `values`.  Items whose reference is NaN have no answer and do not count.
/// A value that is NaN counts as 0.
Errors measure(std::span<const double> values, std::span<const double> reference, double dark);

/// Mean and standard error of answers with different seeds, item by item.  All answers have the
/// same weight.
class Replicates {
 public:
  explicit Replicates(std::size_t items) : mean_(items), squares_(items) {}

  void add(std::span<const double> values);
  std::size_t count() const { return count_; }
  const std::vector<double>& mean() const { return mean_; }
  /// Standard error of each mean; 0 for fewer than two answers.
  std::vector<double> standard_error() const;

 private:
  std::size_t count_ = 0;
  std::vector<double> mean_, squares_;
};

}  // namespace lucerna::tradeoff
