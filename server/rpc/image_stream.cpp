#include "server/rpc/image_stream.h"

#include <utility>

#include "lights/maths/stop_poll.h"
#include "lucerna/v1/render.pb.h"
#include "proto/common/status_macros.h"
#include "server/rpc/answer_record.h"
#include "server/rpc/messages/errors.h"

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
  observed_.record().request_bytes = bytes_.Length();
  absl::Status status = guarded([&]() -> absl::Status {
    LUCERNA_RETURN_IF_ERROR(admit());
    v1::RenderImageRequest parsed;
    LUCERNA_RETURN_IF_ERROR(parse_message(bytes_, parsed));
    record_request(parsed, observed_.record());
    LUCERNA_ASSIGN_OR_RETURN(
        RenderImageHandler render,
        RenderImageHandler::create(runtime_.context(observed_.caller()), parsed));
    LUCERNA_RETURN_IF_ERROR(observed_.take_items(render.pixels()));
    render_.emplace(std::move(render));
    return absl::OkStatus();
  });
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
  v1::RenderImageResponse response;
  const std::stop_token stop = stop_.get_token();
  absl::Status status;
  {
    const WorkTime time(record);
    const StopScope scope(stop);
    status = render_->next(stop, &response);
  }
  observed_.count_work();
  if (stop_.stop_requested()) return limit.stopped_status();
  if (!status.ok()) return status;
  record.items += area(response.tile().rect());
  add_counts(response.cost(), record);  // the response counts the work of all tiles so far
  if (!response.has_tile()) return absl::OkStatus();
  set_times(record, response.mutable_cost());
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
