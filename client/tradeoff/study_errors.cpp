#include "client/tradeoff/study_errors.h"

#include <cmath>

namespace lucerna::tradeoff {

double dark_level(std::span<const double> reference) {
  double sum = 0;
  std::size_t count = 0;
  for (const double r : reference) {
    if (std::isnan(r)) continue;
    sum += std::fabs(r);
    ++count;
  }
  return sum > 0 ? kDark * sum / static_cast<double>(count) : 1;
}

double relative_square(double value, double reference, double dark) {
  const double difference = (std::isnan(value) ? 0 : value) - reference;
  return difference * difference / (reference * reference + dark * dark);
}

Errors measure(std::span<const double> values, std::span<const double> reference, double dark) {
  double squares = 0, relative = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    if (std::isnan(reference[i])) continue;
    const double difference = (std::isnan(values[i]) ? 0 : values[i]) - reference[i];
    squares += difference * difference;
    relative += relative_square(values[i], reference[i], dark);
    ++count;
  }
  if (count == 0) return {};
  const auto n = static_cast<double>(count);
  return {.rmse = std::sqrt(squares / n), .relative_mse = relative / n, .flip = {}};
}

// Summing differences from the current mean avoids cancellation.  [Welford62]
void Replicates::add(std::span<const double> values) {
  ++count_;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double before = values[i] - mean_[i];
    mean_[i] += before / static_cast<double>(count_);
    squares_[i] += before * (values[i] - mean_[i]);
  }
}

std::vector<double> Replicates::standard_error() const {
  std::vector<double> result(mean_.size());
  if (count_ < 2) return result;
  const auto n = static_cast<double>(count_);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = std::sqrt(squares_[i] / (n * (n - 1)));
  }
  return result;
}

}  // namespace lucerna::tradeoff
