#include "server/rpc/handlers/find_missing_assets_handler.h"

#include <fmt/core.h>

#include <set>

#include "proto/common/status_macros.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/scene_manifest.h"

namespace lucerna::rpc {
namespace {

// Predicted processor time of one digest [s], rounded up.
constexpr double kAssetSeconds = 1e-6;

}  // namespace

Prepared handle_find_missing_assets(const CallContext& context,
                                    const v1::FindMissingAssetsRequest& request,
                                    v1::FindMissingAssetsResponse* response) {
  const auto n = static_cast<std::size_t>(request.sha256_size());
  LUCERNA_RETURN_IF_ERROR(check_limit("sha256", n, context.limits.max_batch_items));
  for (std::size_t i = 0; i < n; ++i) {
    const std::string& digest = request.sha256(static_cast<int>(i));
    LUCERNA_RETURN_IF_ERROR(check_digest(fmt::format("sha256[{}]", i), digest));
  }
  const auto run = [&assets = context.assets, &request, response](const std::stop_token&) {
    std::set<std::string> seen;
    for (const std::string& digest : request.sha256()) {
      if (!seen.insert(digest).second) continue;
      const AssetStore::Held held = assets.held(digest);
      if (held.whole) continue;
      response->add_missing_sha256(digest);
      response->add_received_bytes(held.bytes);
    }
    return absl::OkStatus();
  };
  return Task{.predicted_s = kAssetSeconds * static_cast<double>(n), .run = run};
}

}  // namespace lucerna::rpc
