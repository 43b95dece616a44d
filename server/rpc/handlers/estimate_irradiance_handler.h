// EstimateIrradiance without gRPC.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_estimate_irradiance(const CallContext& context,
                                    const v1::EstimateIrradianceRequest& request,
                                    v1::EstimateIrradianceResponse* response);

}  // namespace lucerna::rpc
