// The answer of a server's health service.
#pragma once

#include <grpc/health/v1/health.pb.h>
#include <grpcpp/generic/generic_stub.h>

#include <future>
#include <string>

#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {

/// The status of one service by its full name, or of the whole server.
inline grpc::health::v1::HealthCheckResponse::ServingStatus health(Service& service,
                                                                   const std::string& name) {
  using Request = grpc::health::v1::HealthCheckRequest;
  using Response = grpc::health::v1::HealthCheckResponse;
  grpc::TemplatedGenericStub<Request, Response> stub(service.channel);
  grpc::ClientContext context;
  Request request;
  request.set_service(name);
  Response response;
  std::promise<grpc::Status> done;
  stub.UnaryCall(&context, "/grpc.health.v1.Health/Check", {}, &request, &response,
                 [&](grpc::Status s) { done.set_value(std::move(s)); });
  const grpc::Status s = done.get_future().get();
  EXPECT_TRUE(s.ok()) << s.error_message();
  return response.status();
}

}  // namespace lucerna::testing
