// lucerna: queries lucernad from the command line.
#include <cstdio>
#include <exception>

#include "client/cli/commands.h"
#include "client/terminal/error.h"

int main(int argc, char** argv) {
  try {
    return lucerna::cli::run_lucerna(argc, argv);
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "lucerna: %s\n", error.what());
    return lucerna::cli::kServerRefused;
  }
}
