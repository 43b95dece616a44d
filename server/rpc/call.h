// Runs tasks as gRPC calls.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>
#include <utility>

#include "server/rpc/answer_record.h"
#include "server/rpc/observed_call.h"
#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// The status in gRPC's form.  Puts the retry delay into the trailing metadata of `context`, and
/// logs INTERNAL errors.
grpc::Status to_grpc(const absl::Status& status, grpc::ServerContextBase& context);

/// gRPC's deadline; the largest time point if there is none.
LaneJob::Clock::time_point deadline_of(gpr_timespec deadline);

/// One unary call.  Small tasks run at once on gRPC's thread, others in a lane.  The call lives
/// until both gRPC and the lane have released it.
///
/// The call gets the bytes of its request, because gRPC answers bytes that it cannot parse with
/// UNIMPLEMENTED and no reason.
class UnaryCall : public grpc::ServerUnaryReactor, public std::enable_shared_from_this<UnaryCall> {
 public:
  void OnCancel() override {
    stop_.request_stop();
    observed_.cancelled();
  }
  void OnDone() override { const auto last = std::move(self_); }

 protected:
  UnaryCall(Runtime& runtime, grpc::CallbackServerContext* context, monitor::Call call,
            grpc::ByteBuffer* response)
      : runtime_(runtime), observed_(runtime, *context, call), response_(response) {}
  /// Requires that a shared pointer owns the call.
  void begin(const grpc::ByteBuffer& request);

 private:
  virtual absl::Status parse(const grpc::ByteBuffer& request, monitor::CallRecord& record) = 0;
  virtual Prepared prepare(const Context& context) = 0;
  virtual absl::Status encode(grpc::ByteBuffer& response, monitor::CallRecord& record) = 0;

  void compute(const Task& task);
  void finish(absl::Status status);

  Runtime& runtime_;
  ObservedCall observed_;
  grpc::ByteBuffer* response_;
  std::stop_source stop_;
  CallGate::Pass pass_;
  access::Admission admission_;
  std::shared_ptr<UnaryCall> self_;
};

template <typename Request, typename Response>
class TypedCall final : public UnaryCall {
 public:
  using Handler = std::function<Prepared(const Context&, const Request&, Response*)>;

  static grpc::ServerUnaryReactor* start(Runtime& runtime, grpc::CallbackServerContext* context,
                                         monitor::Call call, const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response, Handler handler) {
    const auto made =
        std::make_shared<TypedCall>(runtime, context, call, response, std::move(handler));
    made->begin(*request);
    return made.get();
  }

  TypedCall(Runtime& runtime, grpc::CallbackServerContext* context, monitor::Call call,
            grpc::ByteBuffer* response, Handler handler)
      : UnaryCall(runtime, context, call, response), handler_(std::move(handler)) {}

 private:
  absl::Status parse(const grpc::ByteBuffer& bytes, monitor::CallRecord& record) override {
    const absl::Status status = parse_message(bytes, request_);
    if (status.ok()) record_request(request_, record);
    return status;
  }
  Prepared prepare(const Context& context) override {
    return handler_(context, request_, &response_);
  }
  absl::Status encode(grpc::ByteBuffer& bytes, monitor::CallRecord& record) override {
    record_answer(request_, response_, record);
    return encode_message(response_, bytes);
  }

  Handler handler_;
  Request request_;
  Response response_;
};

}  // namespace lucerna::rpc
