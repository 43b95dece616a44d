// GetScene without gRPC.
#pragma once

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_get_scene(const CallContext& context, const v1::GetSceneRequest& request,
                          v1::GetSceneResponse* response);

}  // namespace lucerna::rpc
