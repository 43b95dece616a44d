// What a server tells of itself: its metrics, GetStats and GetServerInfo.
#pragma once

#include "lucerna/v1/admin.pb.h"
#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// All statistics now, also of calls that nobody made.  Takes time in proportion to the number of
/// loaded scenes.
v1::GetStatsResponse stats(const Runtime& runtime);

Prepared handle_get_stats(Runtime& runtime, const v1::GetStatsRequest&,
                          v1::GetStatsResponse* response);
Prepared handle_get_server_info(Runtime& runtime, const v1::GetServerInfoRequest&,
                                v1::GetServerInfoResponse* response);

}  // namespace lucerna::rpc
