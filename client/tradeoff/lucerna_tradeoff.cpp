// lucerna-tradeoff: measures error against time through a running server, and makes the page.
#include <cstdio>
#include <exception>

#include "client/terminal/error.h"
#include "client/tradeoff/study_command.h"

int main(int argc, char** argv) {
  try {
    return lucerna::tradeoff::run_tradeoff(argc, argv);
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "lucerna: %s\n", error.what());
    return lucerna::cli::kServerRefused;
  }
}
