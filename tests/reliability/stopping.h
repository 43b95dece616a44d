// The client that the row `stopping` kills.
#pragma once

#include <string>

namespace lucerna::reliability {

/// Makes the call `method` with the encoded request in `file`, until it ends.  Returns 0.
int run_endless(const std::string& target, const std::string& method, const std::string& file);

}  // namespace lucerna::reliability
