// SampleLi without gRPC.
#pragma once

#include "lucerna/v1/lighting.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

Prepared handle_sample_li(const CallContext& context, const v1::SampleLiRequest& request,
                          v1::SampleLiResponse* response);

}  // namespace lucerna::rpc
