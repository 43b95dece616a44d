// The command line of lucernad.
#pragma once

#include <optional>
#include <string>

#include "server/lucernad/configuration.h"

namespace lucerna::config {

struct CommandLine {
  Given given;         ///< with the environment of this process
  bool check = false;  ///< --check-config
  /// The program ends at once with this exit status: after --help, --version or a wrong option.
  std::optional<int> exit_status;
};

/// Prints help, version and errors of syntax.  The values of settings are not checked yet.
CommandLine parse_command_line(int argc, const char* const* argv, const std::string& version);

}  // namespace lucerna::config
