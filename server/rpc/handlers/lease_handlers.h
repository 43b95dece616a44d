// RenewLease and ReleaseScene without gRPC.
#pragma once

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_renew_lease(const CallContext& context, const v1::RenewLeaseRequest& request,
                            v1::RenewLeaseResponse* response);
Prepared handle_release_scene(const CallContext& context, const v1::ReleaseSceneRequest& request,
                              v1::ReleaseSceneResponse* response);

}  // namespace lucerna::rpc
