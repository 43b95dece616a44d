// Records the calls that gRPC answers itself: health, reflection, and calls that do not exist.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// Makes an interceptor for each such call, and none for the calls of the contract: these have an
/// ObservedCall.  Such a call computes nothing, has no items, and needs no token.
class OtherCalls final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  /// `runtime` must live as long as gRPC's server.
  explicit OtherCalls(Runtime& runtime) : runtime_(runtime) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override;

 private:
  Runtime& runtime_;
};

}  // namespace lucerna::rpc
