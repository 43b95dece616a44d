// What a server tells of itself: the figures of its metrics, GetStats and GetServerInfo.
#pragma once

#include "lucerna/v1/admin.pb.h"
#include "server/monitor/figures.h"
#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// All figures now.  Takes time in proportion to the number of loaded scenes.
monitor::Figures figures(const Runtime& runtime);

Prepared handle_get_stats(Runtime& runtime, const v1::GetStatsRequest&,
                          v1::GetStatsResponse* response);
Prepared handle_get_server_info(Runtime& runtime, const v1::GetServerInfoRequest&,
                                v1::GetServerInfoResponse* response);

}  // namespace lucerna::rpc
