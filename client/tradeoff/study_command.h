// The program lucerna-tradeoff.
#pragma once

namespace lucerna::tradeoff {

/// Returns the exit status.
int run_tradeoff(int argc, char** argv);

}  // namespace lucerna::tradeoff
