// The four services on gRPC's callback API.
#pragma once

#include <grpcpp/impl/service_type.h>

#include <memory>
#include <string>
#include <vector>

#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// Full names of all services, e.g. "lucerna.v1.SceneService".
std::vector<std::string> service_names();

/// One object for each service.  `runtime` must outlive them.
std::vector<std::unique_ptr<grpc::Service>> make_services(Runtime& runtime);

}  // namespace lucerna::rpc
