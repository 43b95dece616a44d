// TestVisibility without gRPC.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_test_visibility(const CallContext& context,
                                const v1::TestVisibilityRequest& request,
                                v1::TestVisibilityResponse* response);

}  // namespace lucerna::rpc
