#include "server/rpc/call.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "server/rpc/messages/errors.h"
#include "server/runtime/parallel.h"

namespace lucerna::rpc {
namespace {
// Shorter tasks run on gRPC's thread, because passing them to a lane costs about as much.
constexpr double kAtOnceSeconds = 50e-6;
// Longer tasks run in the bulk lane, so that small queries do not wait for them.
constexpr double kBulkSeconds = 0.1;
// A caller with too many requests in flight may try again after about one small request.
constexpr std::chrono::milliseconds kQuotaDelay(50);
}  // namespace

grpc::Status to_grpc(const absl::Status& status, grpc::ServerContextBase& context) {
  if (status.ok()) return grpc::Status::OK;
  const WireError error = to_wire(status);
  if (error.code == grpc::StatusCode::INTERNAL) spdlog::error(status.ToString());
  if (error.pushback) {
    context.AddTrailingMetadata("grpc-retry-pushback-ms",
                                fmt::format("{}", error.pushback->count()));
  }
  return {static_cast<grpc::StatusCode>(error.code), error.message, error.details};
}

LaneJob::Clock::time_point deadline_of(const grpc::ServerContextBase& context) {
  return context.deadline();
}

absl::StatusOr<access::Admission> admit(Runtime& runtime, access::Call call,
                                        const grpc::ServerContextBase& context) {
  const auto& metadata = context.client_metadata();
  const auto header = metadata.find("authorization");
  absl::StatusOr<access::Admission> admission = runtime.access.admit(
      call, header == metadata.end()
                ? std::string_view()
                : std::string_view(header->second.data(), header->second.size()));
  if (absl::IsResourceExhausted(admission.status())) {
    return retry_after(admission.status(), Reason::kOverQuota, kQuotaDelay);
  }
  return admission;
}

grpc::ServerUnaryReactor* UnaryCall::start(Runtime& runtime, access::Call which,
                                           grpc::CallbackServerContext* context,
                                           const std::function<Prepared(const Context&)>& prepare) {
  const auto call = std::make_shared<UnaryCall>(runtime, context);
  call->self_ = call;
  call->begin(which, prepare);
  return call.get();
}

void UnaryCall::begin(access::Call which, const std::function<Prepared(const Context&)>& prepare) {
  pass_ = runtime_.gate.enter();
  if (!pass_) return finish(draining());
  absl::StatusOr<access::Admission> admission = admit(runtime_, which, *context_);
  if (!admission.ok()) return finish(admission.status());
  admission_ = *std::move(admission);
  Prepared task = absl::InternalError("not prepared");
  const absl::Status prepared = guarded([&] {
    task = prepare(runtime_.context(admission_.caller));
    return task.status();
  });
  if (!prepared.ok()) return finish(prepared);
  if (!task->bulk && task->predicted_s < kAtOnceSeconds) return compute(*task, 0);
  const Lane lane =
      task->bulk || task->predicted_s > kBulkSeconds ? Lane::kBulk : Lane::kInteractive;
  const absl::Status queued = runtime_.lanes.submit(
      lane, {.run =
                 [self = shared_from_this(), task = *std::move(task)](const LaneJobStart& start) {
                   if (start.status.ok()) {
                     self->compute(task, start.queue_time_s);
                   } else {
                     self->finish(start.status);
                   }
                 },
             .stop = stop_.get_token(),
             .deadline = deadline_});
  if (!queued.ok()) finish(lane_error(queued, lane));
}

void UnaryCall::compute(const Task& task, double queue_time_s) {
  if (deadline_ <= LaneJob::Clock::now()) {
    return finish(absl::DeadlineExceededError("the deadline passed before the work started"));
  }
  const auto begin = std::chrono::steady_clock::now();
  const CpuMeter meter;
  absl::Status status = guarded([&] { return task.run(stop_.get_token()); });
  // A stopped task may have left its answer incomplete.
  if (stop_.stop_requested()) status = stopped_status(deadline_);
  if (task.cost != nullptr && status.ok()) {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    task.cost->set_cpu_time_s(meter.seconds());
    task.cost->set_wall_time_s(wall.count());
    task.cost->set_queue_time_s(queue_time_s);
  }
  finish(status);
}

void UnaryCall::finish(const absl::Status& status) { Finish(to_grpc(status, *context_)); }

}  // namespace lucerna::rpc
