#include "server/rpc/handlers/le_handler.h"

#include "proto/common/status_macros.h"
#include "server/queries/emission_queries.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/requested_accuracy.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<LeQuery> parse(const CallContext& context, const Scene& scene,
                              const v1::LeRequest& request) {
  LeQuery query;
  LUCERNA_ASSIGN_OR_RETURN(query.points, check_points(context, "points", request.points()));
  const std::size_t n = query.points.size();
  LUCERNA_ASSIGN_OR_RETURN(query.directions,
                           check_triples("directions", request.directions(), n, "points", false));
  LUCERNA_ASSIGN_OR_RETURN(query.light, find_light_if_named(scene, request));
  LUCERNA_ASSIGN_OR_RETURN(query.time_s, check_time(request.time_s()));
  LUCERNA_ASSIGN_OR_RETURN(query.wavelengths_nm, check_wavelengths(request.wavelengths_nm()));
  LUCERNA_RETURN_IF_ERROR(check_grey_media(scene, query.wavelengths_nm));
  LUCERNA_ASSIGN_OR_RETURN(const Methods methods, check_methods(request.accuracy()));
  query.thin_glass = methods.thin_glass;
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "points", n, answer_size(request)));
  return query;
}

LeAnswer sized_arrays(const LeQuery& query, v1::LeResponse* r) {
  const std::size_t n = query.points.size();
  return {
      .radiance_cd_m2 = fill(r->mutable_radiance_cd_m2(), 3 * n),
      .light_ids = fill(r->mutable_light_ids(), n),
      .status = fill(r->mutable_status(), n),
      .spectral_radiance = fill(r->mutable_spectral_radiance(), n * query.wavelengths_nm.size())};
}

}  // namespace

Prepared handle_le(const CallContext& context, const v1::LeRequest& request,
                   v1::LeResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const LeQuery query, parse(context, *scene, request));
  const std::size_t n = query.points.size();
  return batch_task(seconds_of(n, kRaySeconds, query.wavelengths_nm.size()), n, response,
                    [scene, query, response](const std::stop_token& stop) {
                      return finish_batch(response,
                                          le(*scene, query, sized_arrays(query, response), stop));
                    });
}

}  // namespace lucerna::rpc
