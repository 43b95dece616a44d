// What all services of one server share.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

#include "lucerna/v1/admin.pb.h"
#include "server/rpc/messages/task.h"
#include "server/runtime/lanes.h"
#include "server/store/scene_store.h"

namespace lucerna::rpc {

/// Counts the calls that are being answered.  Thread-safe.
class CallGate {
 public:
  /// A call that was let in, until it is destroyed.
  class Pass {
   public:
    Pass() = default;
    explicit Pass(CallGate* gate) : gate_(gate) {}
    Pass(Pass&& other) noexcept : gate_(std::exchange(other.gate_, nullptr)) {}
    Pass& operator=(Pass&& other) noexcept {
      std::swap(gate_, other.gate_);
      return *this;
    }
    ~Pass() {
      if (gate_ != nullptr) gate_->leave();
    }
    explicit operator bool() const { return gate_ != nullptr; }

   private:
    CallGate* gate_ = nullptr;
  };

  /// An empty pass once the gate is closed.
  Pass enter();
  void close();
  /// False where calls were still in at `deadline`.
  bool wait_until_empty(std::chrono::steady_clock::time_point deadline);

 private:
  void leave();
  std::mutex mutex_;
  std::condition_variable left_;
  bool closed_ = false;
  std::size_t inside_ = 0;
};

struct Runtime {
  explicit Runtime(Lanes& l) : lanes(l) {}

  RequestLimits limits;
  std::unique_ptr<AssetStore> assets;
  std::unique_ptr<SceneStore> scenes;
  v1::GetServerInfoResponse info;
  CallGate gate;
  Lanes& lanes;

  Context context() { return {*scenes, *assets, limits}; }
};

/// RESOURCE_EXHAUSTED of a lane becomes worth a retry.
absl::Status lane_error(absl::Status status, Lane lane);

/// What to say of work that was told to stop.
absl::Status stopped_status(LaneJob::Clock::time_point deadline);

/// `f()`, its exceptions as errors: no memory is RESOURCE_EXHAUSTED, all others INTERNAL.
absl::Status guarded(const std::function<absl::Status()>& f);

}  // namespace lucerna::rpc
