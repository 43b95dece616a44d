// ListScenes, ListAvailableScenes, ListLights and ListLeases without gRPC.
#pragma once

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_list_scenes(const CallContext& context, const v1::ListScenesRequest& request,
                            v1::ListScenesResponse* response);
Prepared handle_list_available_scenes(const CallContext& context,
                                      const v1::ListAvailableScenesRequest& request,
                                      v1::ListAvailableScenesResponse* response);
Prepared handle_list_lights(const CallContext& context, const v1::ListLightsRequest& request,
                            v1::ListLightsResponse* response);
Prepared handle_list_leases(const CallContext& context, const v1::ListLeasesRequest& request,
                            v1::ListLeasesResponse* response);

}  // namespace lucerna::rpc
