// --time: the moment of a query, for scenes where something moves.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "client/terminal/validators.h"

namespace lucerna::cli {

struct TimeOption {
  void add(CLI::App& command, const std::string& otherwise = "0") {
    command
        .add_option("--time", time_s_,
                    "Moment of the query in a scene with motion [s]; default: " + otherwise)
        ->check(checked_number("a finite number", [](double) { return true; }));
  }

  bool given() const { return time_s_.has_value(); }
  /// Sets the moment if it is given.
  template <typename Request>
  void put(Request& request) const {
    if (time_s_) request.set_time_s(*time_s_);
  }

 private:
  std::optional<double> time_s_;
};

}  // namespace lucerna::cli
