#include "server/rpc/handlers/lease_handlers.h"

#include "proto/common/status_macros.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

// Predicted time of a new end of a lease [s], rounded up.
constexpr double kRenewSeconds = 2e-6;
// Time of freeing a large scene [s].
constexpr double kReleaseSeconds = 1;

}  // namespace

Prepared handle_renew_lease(const CallContext& context, const v1::RenewLeaseRequest& request,
                            v1::RenewLeaseResponse* response) {
  LUCERNA_RETURN_IF_ERROR(find_scene(context, request.scene_id()).status());
  if (!(request.lease_s() > 0)) {
    return bad_field("lease_s", request.lease_s(), "(0, inf)");
  }
  LUCERNA_RETURN_IF_ERROR(check_lease(request.lease_s()));
  const auto run = [&scenes = context.scenes, &request, caller = context.caller,
                    response](const std::stop_token&) -> absl::Status {
    const absl::StatusOr<Lease> lease =
        scenes.lease(request.scene_id(), request.lease_id(), request.lease_s(), caller);
    if (!lease.ok()) return load_error(lease.status());
    response->set_lease_id(lease->id);
    response->set_lease_s(lease->seconds);
    return absl::OkStatus();
  };
  return Task{.predicted_s = kRenewSeconds, .run = run};
}

Prepared handle_release_scene(const CallContext& context, const v1::ReleaseSceneRequest& request,
                              v1::ReleaseSceneResponse* response) {
  LUCERNA_RETURN_IF_ERROR(find_scene(context, request.scene_id()).status());
  if (request.break_leases() && !context.caller.admin) {
    return absl::PermissionDeniedError("break_leases needs the role admin");
  }
  const auto run = [&scenes = context.scenes, &request, caller = context.caller,
                    response](const std::stop_token&) -> absl::Status {
    if (request.break_leases()) return scenes.break_leases(request.scene_id());
    LUCERNA_ASSIGN_OR_RETURN(const bool gone,
                             scenes.release(request.scene_id(), request.lease_id(), caller));
    response->set_still_loaded(!gone);
    return absl::OkStatus();
  };
  return Task{.predicted_s = kReleaseSeconds, .run = run};
}

}  // namespace lucerna::rpc
