#include "client/library/retry.h"

#include <string>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "lucerna/client/client.h"

namespace lucerna::client {

std::optional<std::chrono::milliseconds> retry_delay(const absl::Status& status) {
  const auto payload = status.GetPayload(kStatusPayloadUrl);
  google::rpc::Status wire;
  if (!payload || !wire.ParseFromString(std::string(*payload))) return std::nullopt;
  for (const auto& detail : wire.details()) {
    google::rpc::RetryInfo retry;
    if (!detail.UnpackTo(&retry)) continue;
    return std::chrono::milliseconds(retry.retry_delay().seconds() * 1000 +
                                     retry.retry_delay().nanos() / 1'000'000);
  }
  return std::nullopt;
}

}  // namespace lucerna::client
