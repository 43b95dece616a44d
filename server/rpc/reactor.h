// What all calls have in common: how they begin, read, stop and end.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <utility>

#include "server/rpc/observed_call.h"
#include "server/rpc/runtime.h"
#include "server/rpc/waits.h"

namespace lucerna::rpc {

/// One call.  Lives until gRPC and the lanes have released it.
///
/// A call gets the bytes of its messages, because gRPC answers bytes that it cannot parse with
/// UNIMPLEMENTED and no reason.
class Reactor : public grpc::ServerGenericBidiReactor,
                public std::enable_shared_from_this<Reactor> {
 public:
  /// Begins a call of the class T.
  template <typename T>
  static Reactor* start(Runtime& runtime, grpc::CallbackServerContext& context,
                        monitor::Call call) {
    const auto made = std::make_shared<T>(runtime, context, call);
    made->self_ = made;
    static_cast<Reactor&>(*made).begin();
    return made.get();
  }

  void OnCancel() override;
  void OnReadDone(bool ok) final;
  void OnDone() final { const auto last = std::move(self_); }

  Reactor(Runtime& runtime, grpc::CallbackServerContext& context, monitor::Call call)
      : runtime_(runtime), observed_(runtime, context, call) {}

 protected:
  /// Reads the first message.
  virtual void begin();
  /// Admits a call of the contract.  Errors: the server shuts down; those of ObservedCall::admit.
  absl::Status admit();
  /// Takes `bytes_`, the next message.  `ok` is false if the client sends no more.
  virtual void take(bool ok) = 0;
  /// Ends the call.
  virtual void finish(absl::Status status) { Finish(observed_.end(status)); }
  /// Ends the call with `bytes_` as its answer, or with an error.
  void send_last(const absl::Status& status);
  /// Ends the call, whose message did not arrive in time.  Must not wait.
  virtual void give_up() { finish(stalled()); }
  /// The error of such a call.
  virtual absl::Status stalled() const;

  /// Reads the next message into `bytes_`.  Gives up after `patience`.
  void read(std::chrono::steady_clock::duration patience);
  static absl::Status cancelled() { return absl::CancelledError("the client cancelled the call"); }
  /// How long a connection may be idle.
  std::chrono::steady_clock::duration idle_time() const;

  Runtime& runtime_;
  CallsInFlight::Counted in_flight_;  // of calls of the contract; the last to be destroyed
  ObservedCall observed_;
  std::stop_source stop_;
  grpc::ByteBuffer bytes_;

 private:
  std::shared_ptr<Reactor> self_;
  Waits::Wait wait_;
  std::atomic<std::uint64_t> reading_ = 0;  // id of the wait; 0: none.  Who takes it goes on.
};

/// A stream of the health or reflection service.  It needs no token, so there is a number of slots.
/// RESOURCE_EXHAUSTED with a RetryInfo if none is free.
class OpenStream : public Reactor {
 public:
  using Reactor::Reactor;
  ~OpenStream() override {
    if (has_slot_) ++runtime_.stream_slots;
  }

 private:
  void begin() override;

  bool has_slot_ = false;
};

}  // namespace lucerna::rpc
