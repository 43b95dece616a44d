// A parsed request that is not computed yet.  Handlers use messages but not gRPC.  Callers of tasks
// use gRPC but do not know what tasks compute.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <stop_token>
#include <utility>

#include "lucerna/v1/accuracy.pb.h"
#include "server/files/asset_store.h"
#include "server/rpc/messages/request_limits.h"
#include "server/runtime/lanes.h"
#include "server/store/scene_store.h"

namespace lucerna::rpc {

/// The data that handlers use.
struct CallContext {
  SceneStore& scenes;
  AssetStore& assets;
  RequestLimits limits;
  Owner caller{};  ///< whose leases and scenes the request makes
};

/// Its request and response must live until `run` has returned.
struct Task {
  /// An upper estimate of the processor time [s].  It decides where the task runs.
  double predicted_s = 0;
  /// True: runs in the bulk lane for any predicted time.
  bool bulk = false;
  /// The kind of its job in the bulk lane.
  JobKind kind = JobKind::kComputation;
  /// Receivers, points, rays, segments, lights or pixels of the answer.  They count against the
  /// caller's quota.
  std::uint64_t items = 0;
  /// Fills the response.  Stops soon after the token requests it; the response is then incomplete.
  std::function<absl::Status(const std::stop_token&)> run{};
  /// Gets the times of the work; null if the response has no such field.
  v1::Cost* cost = nullptr;
};

/// The task of a call whose answer has its cost.
template <typename Response, typename Run>
Task batch_task(double predicted_s, std::uint64_t items, Response* response, Run run) {
  return {.predicted_s = predicted_s,
          .items = items,
          .run = std::move(run),
          .cost = response->mutable_cost()};
}

/// A task, or an error that is known before the work starts.
using Prepared = absl::StatusOr<Task>;

}  // namespace lucerna::rpc
