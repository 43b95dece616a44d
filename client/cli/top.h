// The table of `lucerna top`.
#pragma once

#include <string>

#include "lucerna/v1/admin.pb.h"

namespace lucerna::cli {

/// What the server does, as a few tables.  Rates and means are those between `before` and `now`.
/// Null: since the server started.  A server that has restarted since `before` counts as new.
std::string top_text(const v1::GetStatsResponse* before, const v1::GetStatsResponse& now,
                     bool colours = false);

}  // namespace lucerna::cli
