// EditLights without gRPC.
#pragma once

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_edit_lights(const CallContext& context, const v1::EditLightsRequest& request,
                            v1::EditLightsResponse* response);

}  // namespace lucerna::rpc
