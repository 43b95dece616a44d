// RenderTile without gRPC.
#pragma once

#include "lucerna/v1/render.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_render_tile(const CallContext& context, const v1::RenderTileRequest& request,
                            v1::RenderTileResponse* response);

}  // namespace lucerna::rpc
