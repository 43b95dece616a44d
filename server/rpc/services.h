// All calls, on gRPC's callback API.
#pragma once

#include <grpcpp/generic/async_generic_service.h>

#include <memory>
#include <string>
#include <vector>

#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// Full names of all services, e.g. "lucerna.v1.SceneService", with those of health and reflection.
std::vector<std::string> service_names();

/// Begins all calls.  `runtime` must outlive it.
std::unique_ptr<grpc::CallbackGenericService> make_service(Runtime& runtime);

}  // namespace lucerna::rpc
