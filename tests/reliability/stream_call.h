// One call of any kind, whose answers are read and thrown away.
#pragma once

#include <memory>
#include <optional>

#include "tests/reliability/traffic.h"

namespace lucerna::reliability {

class StreamCall {
 public:
  /// Begins the call.  With `repeated`, sends this message again and again after the first.
  StreamCall(const std::shared_ptr<grpc::Channel>& channel, const Message& message,
             std::optional<Clock::time_point> deadline = std::nullopt,
             std::optional<grpc::ByteBuffer> repeated = std::nullopt);
  /// Cancels the call, and waits for its end.
  ~StreamCall();
  StreamCall(const StreamCall&) = delete;
  StreamCall& operator=(const StreamCall&) = delete;

  /// Works until `until`, or until the call ends.  Returns whether it has ended.
  bool work(Clock::time_point until);
  void cancel() { context_.TryCancel(); }
  /// How the call ended.
  const grpc::Status& status() const { return status_; }

 private:
  enum Step : std::uintptr_t { kStart = 1, kWrite, kRead, kFinish };
  static void* tag(Step step) { return reinterpret_cast<void*>(step); }
  void take(Step step, bool ok);

  grpc::CompletionQueue queue_;
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer first_, answer_;
  std::optional<grpc::ByteBuffer> repeated_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream_;
  grpc::Status status_;
  int open_ = 0;  // operations whose tags the queue still returns
  bool ended_ = false;
};

}  // namespace lucerna::reliability
