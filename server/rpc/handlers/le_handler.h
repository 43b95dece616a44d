// Le without gRPC.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_le(const CallContext& context, const v1::LeRequest& request,
                   v1::LeResponse* response);

}  // namespace lucerna::rpc
