#include "server/rpc/call.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <optional>

#include "lights/maths/stop_poll.h"
#include "proto/common/status_macros.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {
// Shorter tasks run on gRPC's thread, because passing them to a lane costs about as much.
constexpr double kAtOnceSeconds = 50e-6;
// Longer tasks run in the bulk lane, so that small queries do not wait for them.
constexpr double kBulkSeconds = 0.1;
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

LaneJob::Clock::time_point deadline_of(gpr_timespec deadline) {
  using Clock = LaneJob::Clock;
  constexpr auto kLast =
      std::chrono::duration_cast<std::chrono::seconds>(Clock::time_point::max().time_since_epoch());
  const gpr_timespec time = gpr_convert_clock_type(deadline, GPR_CLOCK_REALTIME);
  // gRPC's own conversion wraps.
  if (time.tv_sec >= kLast.count()) return Clock::time_point::max();
  return grpc::Timespec2Timepoint(time);
}

void UnaryCall::take(bool ok) {
  if (!ok) return finish(no_message());
  observed_.request_complete();
  monitor::CallRecord& record = observed_.record();
  record.request_bytes = bytes_.Length();
  Prepared task = absl::InternalError("not prepared");
  const absl::Status prepared = guarded([&]() -> absl::Status {
    LUCERNA_RETURN_IF_ERROR(admit());
    LUCERNA_RETURN_IF_ERROR(parse(bytes_, record));
    task = prepare();
    LUCERNA_RETURN_IF_ERROR(task.status());
    return observed_.take_items(task->items);
  });
  if (!prepared.ok()) return finish(prepared);
  if (!task->bulk && task->predicted_s < kAtOnceSeconds) return compute(*task);
  const Lane lane =
      task->bulk || task->predicted_s > kBulkSeconds ? Lane::kBulk : Lane::kInteractive;
  LaneJob job{.stop = stop_.get_token(),
              .deadline = observed_.deadline(),
              .client = observed_.client(),
              .connection = observed_.connection(),
              .kind = task->kind,
              .least_s = runtime_.times.least_seconds(record.call, task->predicted_s),
              .expected_s = runtime_.times.expected_seconds(record.call, task->predicted_s)};
  const auto self = std::static_pointer_cast<UnaryCall>(shared_from_this());
  job.run = [self, lane, task = *std::move(task)](const LaneJobStart& start) {
    self->observed_.add_queue_time(lane, start.queue_time_s);
    if (start.status.ok()) {
      self->compute(task);
    } else {
      self->finish(start.status);
    }
  };
  const absl::Status queued = runtime_.lanes.submit(lane, std::move(job));
  if (!queued.ok()) finish(lane_error(queued, lane));
}

void UnaryCall::compute(const Task& task) {
  if (observed_.deadline() <= LaneJob::Clock::now()) {
    return finish(absl::DeadlineExceededError("the deadline passed before the work started"));
  }
  if (const absl::Status room = observed_.room_for_answers(); !room.ok()) return finish(room);
  monitor::CallRecord& record = observed_.record();
  std::optional<ComputeLimit> limit;
  if (record.queued) limit.emplace(runtime_, observed_.deadline(), stop_);
  const std::stop_token stop = stop_.get_token();
  absl::Status status;
  try {
    const WorkTime time(record);
    const StopScope scope(stop);
    status = task.run(stop);
  } catch (...) {
    status = status_of_exception();
  }
  // A stopped task may have left its answer incomplete.
  const bool stopped = stop_.stop_requested();
  if (stopped) status = limit ? limit->stopped_status() : stopped_status(observed_.deadline());
  observed_.count_work();
  if (status.ok()) runtime_.times.learn(record.call, task.predicted_s, record.compute_s);
  if (task.cost != nullptr && status.ok()) set_times(record, task.cost);
  finish(status);
}

void UnaryCall::finish(absl::Status status) {
  if (status.ok()) {
    bytes_.Clear();
    status = guarded([&] { return encode(bytes_, observed_.record()); });
  }
  send_last(status);
}

}  // namespace lucerna::rpc
