// RenderImage as a gRPC stream.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include "lucerna/v1/render.pb.h"
#include "server/rpc/handlers/image_render.h"
#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// Renders one tile in each lane job, so that other renders can run between two tiles.  Stays at
/// most a few tiles ahead of the client.
class ImageStream : public grpc::ServerWriteReactor<v1::RenderImageResponse>,
                    public std::enable_shared_from_this<ImageStream> {
 public:
  static grpc::ServerWriteReactor<v1::RenderImageResponse>* start(
      Runtime& runtime, grpc::CallbackServerContext* context,
      const v1::RenderImageRequest& request);

  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { const auto last = std::move(self_); }
  void OnWriteDone(bool ok) override;

  ImageStream(Runtime& runtime, grpc::CallbackServerContext* context);

 private:
  void begin(const v1::RenderImageRequest& request);
  LaneJob next_job();
  void render_next(const LaneJobStart& start);
  /// Starts the next step: a write, a lane job, or the end.
  void advance();

  Runtime& runtime_;
  grpc::CallbackServerContext* context_;
  LaneJob::Clock::time_point deadline_;
  std::stop_source stop_;
  CallGate::Pass pass_;
  access::Admission admission_;
  std::shared_ptr<ImageStream> self_;

  std::optional<ImageRender> render_;  // while a lane job runs, only the job uses it
  double queue_s_ = 0, wall_s_ = 0, cpu_s_ = 0;

  std::mutex mutex_;
  std::deque<v1::RenderImageResponse> ready_;  // if writing_, the first is being written
  bool job_ = false, writing_ = false, complete_ = false, finished_ = false;
  absl::Status error_;
};

}  // namespace lucerna::rpc
