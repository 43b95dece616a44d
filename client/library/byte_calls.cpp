#include "client/library/byte_calls.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <optional>
#include <utility>
#include <vector>

#include "client/library/call_context.h"
#include "client/library/channel.h"
#include "client/library/status.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

absl::StatusOr<std::string> bytes_of(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  if (const grpc::Status status = buffer.Dump(&slices); !status.ok()) return to_absl_status(status);
  std::string bytes;
  bytes.reserve(buffer.Length());
  for (const grpc::Slice& slice : slices)
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return bytes;
}

}  // namespace

class ByteCalls::Connection {
 public:
  explicit Connection(const std::shared_ptr<grpc::Channel>& channel) : stub(channel) {}
  // Beginning a call changes nothing in a stub, but gRPC's method is not const.
  mutable grpc::GenericStub stub;
};

ByteCalls::ByteCalls(std::shared_ptr<const Connection> connection)
    : connection_(std::move(connection)) {}

absl::StatusOr<ByteCalls> ByteCalls::connect(ConnectOptions options) {
  options.retry = false;
  LUCERNA_ASSIGN_OR_RETURN(const auto channel, make_channel(options));
  return ByteCalls(std::make_shared<Connection>(channel));
}

void ByteCalls::call(const std::string& method, const std::string& request,
                     const CallOptions& options, Done done) const {
  struct State {
    State(const std::string& bytes, const CallOptions& options) : context(std::in_place, options) {
      const grpc::Slice slice(bytes);
      request = grpc::ByteBuffer(&slice, 1);
    }
    grpc::ByteBuffer request, response;
    std::optional<CallContext> context;
  };
  const auto state = std::make_shared<State>(request, options);
  connection_->stub.UnaryCall(state->context->get(), method, {}, &state->request, &state->response,
                              [state, done = std::move(done)](const grpc::Status& status) {
                                // As in client.cpp: the context must not outlive the client.
                                state->context.reset();
                                if (status.ok()) {
                                  done(bytes_of(state->response));
                                } else {
                                  done(to_absl_status(status));
                                }
                              });
}

}  // namespace lucerna::client
