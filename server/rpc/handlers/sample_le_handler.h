// SampleLe without gRPC.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_sample_le(const CallContext& context, const v1::SampleLeRequest& request,
                          v1::SampleLeResponse* response);

}  // namespace lucerna::rpc
