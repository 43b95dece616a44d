#include "server/rpc/handlers/get_scene_handler.h"

#include "proto/common/status_macros.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"

namespace lucerna::rpc {
namespace {

// Predicted processor time of one entry [s], rounded up.
constexpr double kEntrySeconds = 2e-6;

}  // namespace

Prepared handle_get_scene(const CallContext& context, const v1::GetSceneRequest& request,
                          v1::GetSceneResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const StoredScene stored, find_stored(context, request.scene_id()));
  const std::size_t entries =
      1 + stored.scene->report().remarks.size() + stored.scene->report().assets.size();
  const auto run = [stored, response](const std::stop_token&) {
    set_summary(stored, response->mutable_summary());
    add_remarks(*stored.scene, response->mutable_remarks());
    set_parts(*stored.scene, response);
    set_contents(*stored.scene, response->mutable_contents());
    return absl::OkStatus();
  };
  return Task{.predicted_s = kEntrySeconds * static_cast<double>(entries), .run = run};
}

}  // namespace lucerna::rpc
