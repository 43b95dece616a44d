// A request that was parsed and not yet computed.  Handlers know messages and not gRPC.  Callers of
// tasks know gRPC and not what tasks compute.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <stop_token>

#include "lucerna/v1/accuracy.pb.h"
#include "server/assets/asset_store.h"
#include "server/rpc/messages/request_limits.h"
#include "server/store/scene_store.h"

namespace lucerna::rpc {

/// What handlers answer from.
struct Context {
  SceneStore& scenes;
  AssetStore& assets;
  const RequestLimits& limits;
};

/// The request and the response that it was made for must live until `run` has returned.
struct Task {
  /// An upper estimate of the processor time [s].  It decides where the task runs.
  double predicted_s = 0;
  /// True: runs in the bulk lane whatever its predicted time.
  bool bulk = false;
  /// Fills the response.  Stops soon after the token requests it; the response is then incomplete.
  std::function<absl::Status(const std::stop_token&)> run;
  /// Gets the times of the work; null if the response has no such field.
  v1::Cost* cost = nullptr;
};

/// Most errors of a request are known before any work.
using Prepared = absl::StatusOr<Task>;

}  // namespace lucerna::rpc
