// --samples, --error and --budget: when a computation stops.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lucerna/v1/accuracy.pb.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

struct StopOption {
  std::optional<std::uint32_t> samples;
  std::optional<double> error, budget_s;

  /// `of` names the item that has samples ("point"), `otherwise` the default number of samples,
  /// `unit` the unit of the answer.
  void add(CLI::App& command, const std::string& of, const std::string& otherwise,
           const std::string& unit);

  double confidence() const { return confidence_.value_or(0.95); }

  /// Sets the given options; the others leave the request unchanged.
  template <typename Request>
  void put(Request& request) const {
    if (samples) request.mutable_accuracy()->set_samples(*samples);
    if (budget_s) request.mutable_accuracy()->set_time_budget_s(*budget_s);
    if (!error) return;
    v1::TargetError* target = request.mutable_accuracy()->mutable_target_error();
    target->set_relative(*error);
    if (floor_) target->set_absolute_floor(*floor_);
    if (confidence_) target->set_confidence(*confidence_);
    if (max_samples_) target->set_max_samples(*max_samples_);
  }

 private:
  std::optional<double> floor_, confidence_;
  std::optional<std::uint32_t> max_samples_;
};

}  // namespace lucerna::cli
