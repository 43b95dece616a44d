// --samples, --error and --budget: when a computation may stop.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "client/terminal/validators.h"
#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::cli {

/// A share as 0.01 or as 1%, which becomes 0.01.
inline CLI::Validator share() {
  return {[](std::string& text) -> std::string {
            const bool percent = text.ends_with('%');
            std::string number = percent ? text.substr(0, text.size() - 1) : text;
            const auto value = read_number<double>(number);
            if (!value || *value <= 0) return text + " is not a share above 0, as 1% or 0.01";
            if (percent) text = fmt::format("{}", *value / 100);
            return {};
          },
          "SHARE"};
}

struct StopOption {
  std::optional<std::uint32_t> samples;
  std::optional<double> error, budget_s;

  /// `of`: what has samples; `otherwise`: how many by default; `unit`: of the answer.
  void add(CLI::App& command, const std::string& of, const std::string& otherwise,
           const std::string& unit) {
    auto* count = command.add_option("--samples", samples,
                                     "Samples for each " + of + "; default " + otherwise);
    count->check(sample_count());
    auto* target = command.add_option(
        "--error", error, "As many samples as each " + of + " needs for this error, as 1% or 0.01");
    target->transform(share())->excludes(count);
    command
        .add_option("--floor", floor_,
                    fmt::format("With --error: no smaller error is asked for [{}]", unit))
        ->check(not_negative())
        ->needs(target);
    command
        .add_option("--confidence", confidence_,
                    "With --error: the chance that it holds; default 95%")
        ->transform(share())
        ->needs(target);
    command
        .add_option("--max-samples", max_samples_,
                    "With --error: for each " + of +
                        " at most, from 64 to the server's limit; default 65536")
        ->check(sample_count(64))
        ->needs(target);
    command
        .add_option("--budget", budget_s,
                    "As many samples as this time allows [s]; or as 10s, 2m, 500ms")
        ->transform(duration())
        ->excludes(count)
        ->excludes(target);
  }

  double confidence() const { return confidence_.value_or(0.95); }

  /// Leaves a request that asks for nothing as it is.
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
