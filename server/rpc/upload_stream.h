// UploadAsset as a gRPC stream.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <cstdint>
#include <optional>

#include "lucerna/v1/scene.pb.h"
#include "server/files/asset_store.h"
#include "server/rpc/reactor.h"

namespace lucerna::rpc {

/// Hashes and writes one message in each lane job, and then reads the next.  If a client sends
/// faster than the disk writes, gRPC's flow control slows it down.
class UploadStream final : public Reactor {
 public:
  UploadStream(Runtime& runtime, grpc::CallbackServerContext& context, monitor::Call call);

 private:
  void begin() override;
  void take(bool ok) override;
  void finish(absl::Status status) override;
  void give_up() override;
  absl::Status stalled() const override;
  /// Handles the message that was read, on a thread of the lane.
  void take_message(const LaneJobStart& start);
  absl::Status take_header(const v1::AssetHeader& header);
  absl::Status take_chunk(const std::string& chunk);
  /// Handles the end of the client's messages.
  absl::Status end();
  /// Reads the next message, and ends the call if too few bytes arrive in time.
  void read_next();

  // At any moment there is one of: a read, a lane job, the end.
  v1::UploadAssetRequest request_;
  v1::UploadAssetResponse response_;
  v1::AssetHeader header_;
  // How long the stream may still wait for messages, and how many bytes it had when that was set.
  std::chrono::steady_clock::duration patience_;
  std::chrono::steady_clock::time_point waits_since_;
  std::uint64_t renewed_at_bytes_ = 0;
  bool begun_ = false;
  std::string client_;  // of observed_, which makes it anew each time
  bool held_ = false;   // the store has the whole asset: the rest of the stream is not read
  std::optional<AssetUpload> upload_;
};

}  // namespace lucerna::rpc
