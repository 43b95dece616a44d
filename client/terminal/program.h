// Parses the command line and runs the command.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "client/terminal/session.h"

namespace lucerna::cli {

/// Describes an error in the command line: the unknown words in the order typed, with the nearest
/// command or option.  Without unknown words, the message of CLI11.
std::string describe(const CLI::App& app, const CLI::ParseError& error);

/// Returns the exit status.  Prints errors and help.
int run_program(CLI::App& app, Session& session, int argc, char** argv);

/// Adds a command that calls `run` with its one argument, or with "" if `argument` is null.
/// `what` and `argument_what`: their help.  `example`: command lines for the end of the help.
CLI::App* add_command(CLI::App& app, const char* name, const char* what, const char* argument,
                      const char* argument_what, const char* example,
                      std::function<void(const std::string&)> run);

}  // namespace lucerna::cli
