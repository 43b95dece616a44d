#include "server/rpc/image_stream.h"

#include <chrono>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "lucerna/v1/render.pb.h"
#include "proto/common/status_macros.h"
#include "server/rpc/answer_record.h"
#include "server/rpc/messages/errors.h"
#include "server/runtime/parallel.h"

namespace lucerna::rpc {
namespace {
// Tiles that may wait for the client, including the one being written.
constexpr std::size_t kTilesAhead = 3;
}  // namespace

ImageStream::ImageStream(Runtime& runtime, grpc::CallbackServerContext& context, monitor::Call call)
    : Reactor(runtime, context, call), client_(observed_.client()) {}

void ImageStream::take(bool ok) {
  if (!ok) return finish(no_message());
  observed_.request_complete();
  absl::Status status;
  observed_.record().request_bytes = bytes_.Length();
  pass_ = runtime_.gate.enter();
  if (!pass_) {
    status = draining();
  } else {
    status = guarded([&]() -> absl::Status {
      LUCERNA_ASSIGN_OR_RETURN(admission_, observed_.admit());
      v1::RenderImageRequest parsed;
      LUCERNA_RETURN_IF_ERROR(parse_message(bytes_, parsed));
      record_request(parsed, observed_.record());
      LUCERNA_ASSIGN_OR_RETURN(
          RenderImageHandler render,
          RenderImageHandler::create(runtime_.context(admission_.caller), parsed));
      counted_items_ = render.pixels();
      LUCERNA_RETURN_IF_ERROR(ObservedCall::take_items(admission_, counted_items_));
      render_.emplace(std::move(render));
      return absl::OkStatus();
    });
  }
  if (status.ok()) {
    {
      const std::lock_guard lock(mutex_);
      job_ = true;
    }
    status = lane_error(runtime_.lanes.submit(Lane::kBulk, next_job()), Lane::kBulk);
    if (status.ok()) return;
  }
  {
    const std::lock_guard lock(mutex_);
    job_ = false;
    error_ = status;
  }
  advance();
}

LaneJob ImageStream::next_job() {
  const auto self = std::static_pointer_cast<ImageStream>(shared_from_this());
  return {.run = [self](const LaneJobStart& start) { self->render_next(start); },
          .stop = stop_.get_token(),
          .deadline = observed_.deadline(),
          .client = client_,
          .connection = observed_.connection(),
          .kind = JobKind::kStep};
}

absl::Status ImageStream::render(grpc::ByteBuffer* bytes) {
  monitor::CallRecord& record = observed_.record();
  const ComputeLimit limit(runtime_, observed_.deadline(), stop_, record.compute_s);
  const auto begin = std::chrono::steady_clock::now();
  const CpuMeter meter;
  v1::RenderImageResponse response;
  const std::stop_token stop = stop_.get_token();
  const StopScope scope(stop);
  const absl::Status status = render_->next(stop, &response);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  record.cpu_s += meter.seconds();
  record.compute_s += wall.count();
  ObservedCall::count_work(admission_, record.cpu_s, counted_items_);
  if (stop_.stop_requested()) return limit.stopped_status();
  if (!status.ok()) return status;
  record.items += area(response.tile().rect());
  add_counts(response.cost(), record);  // the response counts the work of all tiles so far
  if (!response.has_tile()) return absl::OkStatus();
  response.mutable_cost()->set_cpu_time_s(record.cpu_s);
  response.mutable_cost()->set_wall_time_s(record.compute_s);
  response.mutable_cost()->set_queue_time_s(record.queue_s);
  LUCERNA_RETURN_IF_ERROR(encode_message(response, *bytes));
  record.response_bytes += bytes->Length();
  return absl::OkStatus();
}

void ImageStream::render_next(const LaneJobStart& start) {
  observed_.add_queue_time(Lane::kBulk, start.queue_time_s);
  absl::Status status = start.status;
  grpc::ByteBuffer bytes;
  if (status.ok()) status = guarded([&] { return render(&bytes); });
  {
    const std::lock_guard lock(mutex_);
    job_ = false;
    if (status.ok()) {
      if (bytes.Length() > 0) {
        observed_.answer_begun(bytes.Length());
        ready_.push_back(std::move(bytes));
      }
      complete_ = render_->done();
    } else {
      error_ = status;
    }
  }
  advance();
}

void ImageStream::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    observed_.answer_sent(ready_.front().Length());
    ready_.pop_front();
    // The stream is broken.
    if (!ok && error_.ok()) error_ = absl::CancelledError("the stream was closed");
  }
  if (!ok) stop_.request_stop();
  advance();
}

void ImageStream::advance() {
  const grpc::ByteBuffer* write = nullptr;
  bool render = false;
  std::optional<absl::Status> end;
  {
    const std::lock_guard lock(mutex_);
    if (finished_) return;
    if (error_.ok()) {
      if (!writing_ && !ready_.empty()) {
        writing_ = true;
        write = &ready_.front();  // push_back does not move it
      }
      const std::size_t most = observed_.room_for_answers().ok() ? kTilesAhead : 1;
      if (!job_ && !complete_ && ready_.size() < most) render = job_ = true;
      if (complete_ && ready_.empty()) end = absl::OkStatus();
    } else if (!job_ && !writing_) {
      end = error_;
    }
    finished_ = end.has_value();
  }
  // Without the lock: each of these may call advance() on another thread.
  if (write != nullptr) StartWrite(write);
  if (render) runtime_.lanes.resume(Lane::kBulk, next_job());
  if (end) finish(*end);
}

}  // namespace lucerna::rpc
