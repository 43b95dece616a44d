// FindMissingAssets without gRPC.
#pragma once

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_find_missing_assets(const CallContext& context,
                                    const v1::FindMissingAssetsRequest& request,
                                    v1::FindMissingAssetsResponse* response);

}  // namespace lucerna::rpc
