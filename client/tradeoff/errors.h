// How far an answer is from the reference.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lucerna::tradeoff {

/// Below this share of the reference's mean, differences count as if the reference were this large:
/// without it a nearly dark item would decide alone what a relative error is.
inline constexpr double kDark = 0.01;

/// Relative errors below this are those of single precision, in which answers come, and of sums in
/// it: some ten of its last places.
inline constexpr double kRounding = 1e-6;

struct Errors {
  double rmse = 0;               ///< in the unit of the values
  double relative_mse = 0;       ///< mean of (value - reference)^2 / (reference^2 + dark^2)
  std::optional<double> flip{};  ///< of pictures: mean FLIP, 0 to 1
};

/// kDark times the mean of those that are numbers; 1 where that is 0, so that all can be divided by
/// it.
double dark_level(std::span<const double> reference);

/// Squared relative error of one value.
double relative_square(double value, double reference, double dark);

/// Items whose reference is not a number have no answer and do not count; a value that is not one
/// counts as 0.
Errors measure(std::span<const double> values, std::span<const double> reference, double dark);

/// Mean and scatter of answers to different seeds, item by item.  Each is of the same work, so that
/// they count alike.
class Replicates {
 public:
  explicit Replicates(std::size_t items) : mean_(items), squares_(items) {}

  void add(std::span<const double> values);
  std::size_t count() const { return count_; }
  const std::vector<double>& mean() const { return mean_; }
  /// Standard error of each mean; 0 for fewer than two.
  std::vector<double> standard_error() const;

 private:
  std::size_t count_ = 0;
  std::vector<double> mean_, squares_;
};

}  // namespace lucerna::tradeoff
