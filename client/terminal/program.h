// Parses the command line and runs the command.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "client/terminal/session.h"

namespace lucerna::cli {

/// Describes an error in the command line: the unknown words in the order typed, with the nearest
/// command or option.  Without unknown words, the message of CLI11.
std::string describe(const CLI::App& app, const CLI::ParseError& error);

/// Returns the exit status.  Prints errors and help.
int run_program(CLI::App& app, Session& session, int argc, char** argv);

}  // namespace lucerna::cli
