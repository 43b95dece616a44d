// A request that was looked at but not yet computed.  Everything up to here knows messages and not
// gRPC; what runs tasks knows gRPC and not what they compute.
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

/// What requests are answered from.
struct Context {
  SceneStore& scenes;
  AssetStore& assets;
  const RequestLimits& limits;
};

/// The request and the response that it was made for must live until `run` has returned.
struct Task {
  /// An upper estimate of the processor time [s]; what decides where it runs.
  double predicted_s = 0;
  /// True where it never belongs to the small ones, whatever its size.
  bool bulk = false;
  /// Fills the response.  Stops soon after the token asks for it; its answer is then of no use.
  std::function<absl::Status(const std::stop_token&)> run;
  /// Where the times of the work are put; null where the response has no such field.
  v1::Cost* cost = nullptr;
};

/// `StatusOr`: what is wrong with a request is mostly known before any work.
using Prepared = absl::StatusOr<Task>;

}  // namespace lucerna::rpc
