// SceneService without gRPC.
#pragma once

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared find_missing_assets(const Context& context, const v1::FindMissingAssetsRequest& request,
                             v1::FindMissingAssetsResponse* response);
Prepared load_scene(const Context& context, const v1::LoadSceneRequest& request,
                    v1::LoadSceneResponse* response);
Prepared get_scene(const Context& context, const v1::GetSceneRequest& request,
                   v1::GetSceneResponse* response);
Prepared list_scenes(const Context& context, const v1::ListScenesRequest& request,
                     v1::ListScenesResponse* response);
Prepared list_available_scenes(const Context& context,
                               const v1::ListAvailableScenesRequest& request,
                               v1::ListAvailableScenesResponse* response);
Prepared list_lights(const Context& context, const v1::ListLightsRequest& request,
                     v1::ListLightsResponse* response);
Prepared renew_lease(const Context& context, const v1::RenewLeaseRequest& request,
                     v1::RenewLeaseResponse* response);
Prepared release_scene(const Context& context, const v1::ReleaseSceneRequest& request,
                       v1::ReleaseSceneResponse* response);
Prepared list_leases(const Context& context, const v1::ListLeasesRequest& request,
                     v1::ListLeasesResponse* response);

}  // namespace lucerna::rpc
