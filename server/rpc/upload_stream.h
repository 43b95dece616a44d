// UploadAsset as a gRPC stream.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/alarm.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "lucerna/v1/scene.pb.h"
#include "server/assets/asset_store.h"
#include "server/rpc/observed_call.h"
#include "server/rpc/runtime.h"

namespace lucerna::rpc {

/// Hashes and writes one message in each lane job, and then reads the next.  If a client sends
/// faster than the disk writes, gRPC's flow control slows it down.
class UploadStream : public grpc::ServerReadReactor<grpc::ByteBuffer>,
                     public std::enable_shared_from_this<UploadStream> {
 public:
  static grpc::ServerReadReactor<grpc::ByteBuffer>* start(Runtime& runtime,
                                                          grpc::CallbackServerContext* context,
                                                          grpc::ByteBuffer* response);

  void OnCancel() override {
    stop_.request_stop();
    observed_.cancelled();
  }
  void OnDone() override { const auto last = std::move(self_); }
  void OnReadDone(bool ok) override;

  UploadStream(Runtime& runtime, grpc::CallbackServerContext* context, grpc::ByteBuffer* response);

 private:
  /// Handles the message that was read, on a thread of the lane.
  void take(const LaneJobStart& start);
  absl::Status take_header(const v1::AssetHeader& header);
  absl::Status take_chunk(const std::string& chunk);
  /// Handles the end of the client's messages.
  absl::Status end();
  void finish(absl::Status status);
  /// Reads the next message, and ends the call if too few bytes arrive in time.
  void read_next();
  void end_stalled();

  Runtime& runtime_;
  ObservedCall observed_;
  grpc::ByteBuffer* bytes_out_;
  v1::UploadAssetResponse response_;
  std::stop_source stop_;
  CallGate::Pass pass_;
  access::Admission admission_;
  std::shared_ptr<UploadStream> self_;

  std::unique_ptr<grpc::Alarm> stall_;
  // Either the message or the alarm sets it to false and goes on.
  std::atomic<bool> reading_ = false;

  // At any moment there is one of: a read, a lane job, the end.
  grpc::ByteBuffer bytes_;
  v1::UploadAssetRequest request_;
  v1::AssetHeader header_;
  // How long the stream may still wait for messages, and how many bytes it had when that was set.
  std::chrono::steady_clock::duration patience_;
  std::chrono::steady_clock::time_point waits_since_;
  std::uint64_t renewed_at_bytes_ = 0;
  bool begun_ = false;
  bool held_ = false;  // the store has the whole asset: the rest of the stream is not read
  std::optional<AssetUpload> upload_;
};

}  // namespace lucerna::rpc
