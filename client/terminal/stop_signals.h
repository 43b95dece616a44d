// SIGINT and SIGTERM as a stop token.
#pragma once

#include <atomic>
#include <stop_token>

namespace lucerna::cli {

/// Blocks SIGINT and SIGTERM for the program.  The first signal requests a stop, so that the
/// running call ends and leaves no unfinished files.  The second signal ends the program at once.
/// Call it once, before any other thread starts.
std::stop_token stop_on_signals();

/// The number of the first signal; 0 before it arrives.
const std::atomic<int>& first_signal();

}  // namespace lucerna::cli
