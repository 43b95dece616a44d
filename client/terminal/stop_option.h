// --samples, --error and --budget: when a computation stops.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "client/terminal/validators.h"
#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::cli {

/// A fraction above 0, such as 0.01 or 1%.  The text becomes the fraction.  A number of 1 or more
/// must have the percent sign, because users often forget it.
inline CLI::Validator share() {
  return {[](std::string& text) -> std::string {
            const bool percent = text.ends_with('%');
            const std::string number = percent ? text.substr(0, text.size() - 1) : text;
            const auto value = read_number<double>(number);
            if (!value || *value <= 0)
              return text + " is not a fraction above 0, such as 1% or 0.01";
            if (!percent && *value >= 1) {
              return fmt::format("{} is {:g}%; did you mean {}%?", text, 100 * *value, text);
            }
            if (percent) text = fmt::format("{}", *value / 100);
            return {};
          },
          "SHARE"};
}

struct StopOption {
  std::optional<std::uint32_t> samples;
  std::optional<double> error, budget_s;

  /// `of` names the item that has samples ("point"), `otherwise` the default number of samples,
  /// `unit` the unit of the answer.
  void add(CLI::App& command, const std::string& of, const std::string& otherwise,
           const std::string& unit) {
    auto* count = command.add_option("--samples", samples,
                                     "Number of samples for each " + of + "; default " + otherwise);
    count->check(sample_count());
    auto* target = command.add_option(
        "--error", error,
        "Take samples until each " + of + " has this relative error, such as 1% or 0.01");
    target->transform(share())->excludes(count);
    command
        .add_option(
            "--floor", floor_,
            fmt::format("With --error: smallest absolute error that is required [{}]", unit))
        ->check(not_negative())
        ->needs(target);
    command
        .add_option(
            "--confidence", confidence_,
            "With --error: confidence level of the target and of all intervals; default 95%")
        ->transform(share())
        ->needs(target);
    command
        .add_option("--max-samples", max_samples_,
                    "With --error: most samples for each " + of +
                        ", from 64 to the server's limit; default 65536")
        ->check(sample_count(64))
        ->needs(target);
    command
        .add_option("--budget", budget_s,
                    "Take as many samples as this time allows [s]; also 10s, 2m, 1h30m or 500ms")
        ->transform(duration())
        ->excludes(count)
        ->excludes(target);
  }

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
