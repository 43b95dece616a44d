// Runs tasks as gRPC calls.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>

#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// The status in gRPC's form.  Puts the retry delay into the trailing metadata of `context`, and
/// logs INTERNAL errors.
grpc::Status to_grpc(const absl::Status& status, grpc::ServerContextBase& context);

/// Lets the call in, by the header "authorization".  Errors: those of access::Access::admit.
absl::StatusOr<access::Admission> admit(Runtime& runtime, access::Call call,
                                        const grpc::ServerContextBase& context);

/// gRPC's deadline; the largest time point if there is none.
LaneJob::Clock::time_point deadline_of(const grpc::ServerContextBase& context);

/// One unary call.  Small tasks run at once on gRPC's thread, others in a lane.  The call lives
/// until both gRPC and the lane have released it.
class UnaryCall : public grpc::ServerUnaryReactor, public std::enable_shared_from_this<UnaryCall> {
 public:
  static grpc::ServerUnaryReactor* start(Runtime& runtime, access::Call which,
                                         grpc::CallbackServerContext* context,
                                         const std::function<Prepared(const Context&)>& prepare);

  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { const auto last = std::move(self_); }

  UnaryCall(Runtime& runtime, grpc::CallbackServerContext* context)
      : runtime_(runtime), context_(context), deadline_(deadline_of(*context)) {}

 private:
  void begin(access::Call which, const std::function<Prepared(const Context&)>& prepare);
  void compute(const Task& task, double queue_time_s);
  void finish(const absl::Status& status);

  Runtime& runtime_;
  grpc::CallbackServerContext* context_;
  LaneJob::Clock::time_point deadline_;
  std::stop_source stop_;
  CallGate::Pass pass_;
  access::Admission admission_;
  std::shared_ptr<UnaryCall> self_;
};

}  // namespace lucerna::rpc
