// FindSurfaces without gRPC.
#pragma once

#include "lucerna/v1/render.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_find_surfaces(const CallContext& context, const v1::FindSurfacesRequest& request,
                              v1::FindSurfacesResponse* response);

}  // namespace lucerna::rpc
