// EstimatePower without gRPC.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_estimate_power(const CallContext& context, const v1::EstimatePowerRequest& request,
                               v1::EstimatePowerResponse* response);

}  // namespace lucerna::rpc
