// LoadScene without gRPC.
#pragma once

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_load_scene(const CallContext& context, const v1::LoadSceneRequest& request,
                           v1::LoadSceneResponse* response);

}  // namespace lucerna::rpc
