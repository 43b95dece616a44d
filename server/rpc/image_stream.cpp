#include "server/rpc/image_stream.h"

#include <utility>

#include "proto/common/status_macros.h"
#include "server/rpc/call.h"
#include "server/rpc/messages/errors.h"
#include "server/runtime/parallel.h"

namespace lucerna::rpc {
namespace {
// Tiles that may wait for the client, including the one being written.
constexpr std::size_t kTilesAhead = 3;
}  // namespace

ImageStream::ImageStream(Runtime& runtime, grpc::CallbackServerContext* context)
    : runtime_(runtime), context_(context), deadline_(deadline_of(*context)) {}

grpc::ServerWriteReactor<v1::RenderImageResponse>* ImageStream::start(
    Runtime& runtime, grpc::CallbackServerContext* context, const v1::RenderImageRequest& request) {
  const auto stream = std::make_shared<ImageStream>(runtime, context);
  stream->self_ = stream;
  stream->begin(request);
  return stream.get();
}

void ImageStream::begin(const v1::RenderImageRequest& request) {
  absl::Status status;
  pass_ = runtime_.gate.enter();
  if (!pass_) {
    status = draining();
  } else {
    status = guarded([&]() -> absl::Status {
      LUCERNA_ASSIGN_OR_RETURN(admission_, admit(runtime_, access::Call::kRenderImage, *context_));
      absl::StatusOr<ImageRender> render =
          ImageRender::create(runtime_.context(admission_.caller), request);
      if (!render.ok()) return render.status();
      render_.emplace(*std::move(render));
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
  return {
      .run = [self = shared_from_this()](const LaneJobStart& start) { self->render_next(start); },
      .stop = stop_.get_token(),
      .deadline = deadline_};
}

void ImageStream::render_next(const LaneJobStart& start) {
  absl::Status status = start.status;
  v1::RenderImageResponse response;
  if (status.ok()) {
    const auto begin = std::chrono::steady_clock::now();
    const CpuMeter meter;
    status = guarded([&] { return render_->next(stop_.get_token(), &response); });
    if (stop_.stop_requested()) status = stopped_status(deadline_);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    cpu_s_ += meter.seconds();
    wall_s_ += wall.count();
    queue_s_ += start.queue_time_s;
    response.mutable_cost()->set_cpu_time_s(cpu_s_);
    response.mutable_cost()->set_wall_time_s(wall_s_);
    response.mutable_cost()->set_queue_time_s(queue_s_);
  }
  {
    const std::lock_guard lock(mutex_);
    job_ = false;
    if (status.ok()) {
      if (response.has_tile()) ready_.push_back(std::move(response));
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
    ready_.pop_front();
    // The stream is broken.
    if (!ok && error_.ok()) error_ = absl::CancelledError("the stream was closed");
  }
  if (!ok) stop_.request_stop();
  advance();
}

void ImageStream::advance() {
  const v1::RenderImageResponse* write = nullptr;
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
      if (!job_ && !complete_ && ready_.size() < kTilesAhead) render = job_ = true;
      if (complete_ && ready_.empty()) end = absl::OkStatus();
    } else if (!job_ && !writing_) {
      end = error_;
    }
    finished_ = end.has_value();
  }
  // Without the lock: each of these may call advance() on another thread.
  if (write != nullptr) StartWrite(write);
  if (render) runtime_.lanes.resume(Lane::kBulk, next_job());
  if (end) Finish(to_grpc(*end, *context_));
}

}  // namespace lucerna::rpc
