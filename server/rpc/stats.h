// The statistics of a server, for its metrics and for GetStats.
#pragma once

#include "lucerna/v1/admin.pb.h"
#include "server/monitor/figures.h"
#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// All figures now.  Takes time in proportion to the number of loaded scenes.
monitor::Figures figures(const Runtime& runtime);

void set_stats(const monitor::Figures& figures, v1::GetStatsResponse* out);

}  // namespace lucerna::rpc
