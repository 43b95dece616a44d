#include "client/terminal/time_option.h"

#include <CLI/CLI.hpp>

#include "client/terminal/validators.h"

namespace lucerna::cli {

void TimeOption::add(CLI::App& command, const std::string& otherwise) {
  command
      .add_option("--time", time_s_,
                  "Moment of the query in a scene with motion [s]; default: " + otherwise)
      ->check(finite_number());
}

}  // namespace lucerna::cli
