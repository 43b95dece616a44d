// Runs tasks as gRPC calls.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>

#include <memory>
#include <type_traits>

#include "server/rpc/answer_record.h"
#include "server/rpc/reactor.h"
#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// The status in gRPC's form.  Puts the retry delay into the trailing metadata of `context`, and
/// logs INTERNAL errors.
grpc::Status to_grpc(const absl::Status& status, grpc::ServerContextBase& context);

/// gRPC's deadline; the largest time point if there is none.
LaneJob::Clock::time_point deadline_of(gpr_timespec deadline);

/// One unary call.  Small tasks run at once on gRPC's thread, others in a lane.
class UnaryCall : public Reactor {
 public:
  using Reactor::Reactor;

 private:
  void take(bool ok) final;
  void finish(absl::Status status) final;
  virtual absl::Status parse(const grpc::ByteBuffer& request, monitor::CallRecord& record) = 0;
  virtual Prepared prepare() = 0;
  /// Frees the request and the response.
  virtual absl::Status encode(grpc::ByteBuffer& bytes, monitor::CallRecord& record) = 0;

  void compute(const Task& task);
};

/// The call that `handler` answers: from the context of a request, or from the whole server, it
/// makes a Task.
template <auto handler>
class TypedCall;
template <typename Context, typename Request, typename Response,
          Prepared (*handler)(Context&, const Request&, Response*)>
class TypedCall<handler> final : public UnaryCall {
 public:
  using UnaryCall::UnaryCall;

 private:
  absl::Status parse(const grpc::ByteBuffer& bytes, monitor::CallRecord& record) override {
    const absl::Status status = parse_message(bytes, messages_->request);
    if (status.ok()) record_request(messages_->request, record);
    return status;
  }
  Prepared prepare() override {
    auto& [request, response] = *messages_;
    if constexpr (std::is_same_v<Context, Runtime>) {
      return handler(runtime_, request, &response);
    } else {
      return handler(runtime_.context(observed_.caller()), request, &response);
    }
  }
  absl::Status encode(grpc::ByteBuffer& bytes, monitor::CallRecord& record) override {
    record_answer(messages_->request, messages_->response, record);
    const absl::Status status = encode_message(messages_->response, bytes);
    // The client may take the bytes slowly.
    messages_.reset();
    return status;
  }

  struct Messages {
    Request request;
    Response response;
  };
  std::unique_ptr<Messages> messages_ = std::make_unique<Messages>();
};

}  // namespace lucerna::rpc
