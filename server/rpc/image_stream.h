// RenderImage as a gRPC stream.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/byte_buffer.h>

#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "server/rpc/handlers/render_image_handler.h"
#include "server/rpc/reactor.h"

namespace lucerna::rpc {

/// Renders at most one tile in each lane job, so that other renders can run between two tiles.
/// Stays at most a few tiles ahead of what gRPC has taken over.  gRPC buffers more for a client
/// that does not read, so such streams compute for a while; other calls take turns with them.
class ImageStream final : public Reactor {
 public:
  ImageStream(Runtime& runtime, grpc::CallbackServerContext& context, monitor::Call call);

  void OnWriteDone(bool ok) override;

 private:
  void take(bool ok) override;
  LaneJob next_job();
  void render_next(const LaneJobStart& start);
  /// Renders a tile, or a part of its samples.  `bytes` stays empty if no tile is ready to be sent.
  absl::Status render(grpc::ByteBuffer* bytes);
  /// Starts the next step: a write, a lane job, or the end.
  void advance();

  const std::string client_;
  std::optional<RenderImageHandler> render_;  // while a lane job runs, only the job uses it

  std::mutex mutex_;
  std::deque<grpc::ByteBuffer> ready_;  // if writing_, the first is being written
  bool job_ = false, writing_ = false, complete_ = false, finished_ = false;
  absl::Status error_;
};

}  // namespace lucerna::rpc
