#include "server/rpc/handlers/edit_lights_handler.h"

#include "proto/common/status_macros.h"
#include "server/rpc/handlers/light_edits.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"

namespace lucerna::rpc {
namespace {

// Time to make a revision: for each light of the scene, for each edit, and for all of them [s].
constexpr double kLightSeconds = 1e-6, kEditSeconds = 10e-6, kRevisionSeconds = 1e-3;

}  // namespace

Prepared handle_edit_lights(const CallContext& context, const v1::EditLightsRequest& request,
                            v1::EditLightsResponse* response) {
  if (request.has_lease_s()) LUCERNA_RETURN_IF_ERROR(check_lease(request.lease_s()));
  LUCERNA_RETURN_IF_ERROR(find_scene(context, request.scene_id()).status());
  LUCERNA_ASSIGN_OR_RETURN(const StoredScene stored, find_stored(context, request.scene_id()));
  LUCERNA_RETURN_IF_ERROR(check_edits(context, request.edits()));
  Task task;
  task.predicted_s = kRevisionSeconds +
                     kLightSeconds * static_cast<double>(stored.scene->lights().size()) +
                     kEditSeconds * static_cast<double>(request.edits_size());
  // These read files, or may build the scene again.
  for (const v1::LightEdit& edit : request.edits())
    task.bulk |= edit.has_add() || edit.change().has_placement();
  if (task.bulk) task.kind = JobKind::kLoad;
  task.cost = response->mutable_cost();
  task.run = [context, stored, &request, response](const std::stop_token& stop) -> absl::Status {
    LUCERNA_ASSIGN_OR_RETURN(
        const EditedScene edited,
        edited_scene(context, stored, request.edits(), request.lease_s(), stop));
    set_loaded(edited.revision, response);
    for (const std::uint64_t id : edited.new_ids) response->add_light_ids(id);
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
