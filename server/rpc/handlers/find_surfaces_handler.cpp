#include "server/rpc/handlers/find_surfaces_handler.h"

#include "proto/common/status_macros.h"
#include "server/queries/surfaces.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<SurfacesQuery> parse(const CallContext& context,
                                    const v1::FindSurfacesRequest& request) {
  const auto numbers = static_cast<std::size_t>(request.places_size());
  if (numbers % 2 != 0)
    return bad_length("places", numbers, numbers + 1, "two numbers for each place");
  LUCERNA_RETURN_IF_ERROR(check_limit("places", numbers / 2, context.limits.max_batch_items));
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "places", numbers / 2, answer_size(request)));
  LUCERNA_ASSIGN_OR_RETURN(const double time_s, check_time(request.time_s()));
  return SurfacesQuery{.places = view(request.places()), .time_s = time_s};
}

}  // namespace

Prepared handle_find_surfaces(const CallContext& context, const v1::FindSurfacesRequest& request,
                              v1::FindSurfacesResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const SurfacesQuery query, parse(context, request));
  const std::size_t n = query.size();
  const auto run = [scene, query, n, response](const std::stop_token& stop) {
    set(scene->origin(), response->mutable_points()->mutable_origin_m());
    const SurfacesAnswer answer{
        .offsets_m = fill(response->mutable_points()->mutable_offsets_m(), 3 * n),
        .normals = fill(response->mutable_normals(), 3 * n),
        .found = fill_bits(response->mutable_found(), n),
        .light_ids = fill(response->mutable_light_ids(), n),
        .status = fill(response->mutable_status(), n)};
    return finish_batch(response, find_surfaces(*scene, query, answer, stop));
  };
  return batch_task(seconds_of(n, kRaySeconds), n, response, run);
}

}  // namespace lucerna::rpc
