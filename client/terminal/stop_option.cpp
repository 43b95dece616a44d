#include "client/terminal/stop_option.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "client/terminal/validators.h"

namespace lucerna::cli {

void StopOption::add(CLI::App& command, const std::string& of, const std::string& otherwise,
                     const std::string& unit) {
  auto* count = command.add_option("--samples", samples,
                                   "Number of samples for each " + of + "; default " + otherwise);
  count->check(sample_count());
  auto* target = command.add_option(
      "--error", error,
      "Take samples until each " + of + " has this relative error, such as 1% or 0.01");
  target->transform(share())->excludes(count);
  command
      .add_option("--floor", floor_,
                  fmt::format("With --error: smallest absolute error that is required [{}]", unit))
      ->check(not_negative())
      ->needs(target);
  command
      .add_option("--confidence", confidence_,
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

}  // namespace lucerna::cli
