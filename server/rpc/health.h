// The standard health service, grpc.health.v1.
#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <mutex>
#include <optional>

#include "server/rpc/reactor.h"

namespace lucerna::rpc {

/// Check.  NOT_FOUND for services that do not exist.
class HealthCheck final : public Reactor {
 public:
  using Reactor::Reactor;

 private:
  void take(bool ok) override;
};

/// Watch: sends the status, and again when it changes.
class HealthWatch final : public OpenStream {
 public:
  using OpenStream::OpenStream;
  ~HealthWatch() override { runtime_.serving.forget(this); }

  void OnCancel() override;
  void OnWriteDone(bool ok) override;

 private:
  void take(bool ok) override;
  /// May be called again.
  void finish(absl::Status status) override;
  /// Starts the next write, or ends the call.
  void advance();

  std::mutex mutex_;
  std::optional<int> next_;  // the status to send
  bool writing_ = false, cancelled_ = false, finished_ = false;
};

}  // namespace lucerna::rpc
