#include "server/rpc/runtime.h"

#include <exception>
#include <new>

#include "lights/maths/stop_poll.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {

CallsInFlight::Counted CallsInFlight::begin() {
  const std::lock_guard lock(mutex_);
  if (closed_) return {};
  ++count_;
  return Counted(this);
}

void CallsInFlight::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
}

bool CallsInFlight::wait_until_empty(std::chrono::steady_clock::time_point deadline,
                                     std::stop_token hurry) {
  std::unique_lock lock(mutex_);
  return ended_.wait_until(lock, std::move(hurry), deadline, [this] { return count_ == 0; });
}

void CallsInFlight::wait_until_empty() {
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return count_ == 0; });
}

void CallsInFlight::end() {
  // Notified under the lock: a waiting thread may destroy this as soon as it is empty.
  const std::lock_guard lock(mutex_);
  if (--count_ == 0) ended_.notify_all();
}

absl::Status lane_error(absl::Status status, Lane lane) {
  if (status.code() != absl::StatusCode::kResourceExhausted) return status;
  // A delay of about the time of one job of the lane.
  return retry_after(std::move(status), Reason::kQueueFull,
                     std::chrono::milliseconds(lane == Lane::kInteractive ? 50 : 1000));
}

absl::Status stopped_status(LaneJob::Clock::time_point deadline) {
  if (deadline <= LaneJob::Clock::now()) {
    return absl::DeadlineExceededError("the deadline passed during the computation");
  }
  return absl::CancelledError("cancelled during the computation");
}

absl::Status status_of_exception() {
  try {
    throw;
  } catch (const Stopped&) {
    return absl::CancelledError("the work was stopped");
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("not enough memory for this request");
  } catch (const std::exception& e) {
    return absl::InternalError(e.what());  // for the log; to_wire() hides it from callers
  }
}

}  // namespace lucerna::rpc
