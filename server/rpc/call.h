// Runs tasks as gRPC calls.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>

#include <functional>
#include <memory>
#include <utility>

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
  virtual Prepared prepare(const Context& context) = 0;
  /// Frees the request and the response.
  virtual absl::Status encode(grpc::ByteBuffer& bytes, monitor::CallRecord& record) = 0;

  void compute(const Task& task);
};

template <typename Request, typename Response>
class TypedCall final : public UnaryCall {
 public:
  using Handler = std::function<Prepared(const Context&, const Request&, Response*)>;

  TypedCall(Runtime& runtime, grpc::CallbackServerContext& context, monitor::Call call,
            Handler handler)
      : UnaryCall(runtime, context, call), handler_(std::move(handler)) {}

 private:
  absl::Status parse(const grpc::ByteBuffer& bytes, monitor::CallRecord& record) override {
    const absl::Status status = parse_message(bytes, messages_->request);
    if (status.ok()) record_request(messages_->request, record);
    return status;
  }
  Prepared prepare(const Context& context) override {
    return handler_(context, messages_->request, &messages_->response);
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
  Handler handler_;
  std::unique_ptr<Messages> messages_ = std::make_unique<Messages>();
};

}  // namespace lucerna::rpc
