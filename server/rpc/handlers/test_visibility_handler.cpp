#include "server/rpc/handlers/test_visibility_handler.h"

#include <fmt/core.h>

#include "proto/common/status_macros.h"
#include "server/queries/visibility.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/requested_accuracy.h"

namespace lucerna::rpc {
namespace {

absl::Status parse_segments(const CallContext& context, const v1::Segments& segments,
                            VisibilityQuery& query) {
  LUCERNA_ASSIGN_OR_RETURN(const PointArray to,
                           check_points(context, "segments.to", segments.to()));
  if (to.size() != query.from.size()) {
    return bad_length("segments.to.offsets_m", 3 * to.size(), 3 * query.from.size(),
                      "as many as segments.from.offsets_m");
  }
  query.to = to;
  return absl::OkStatus();
}

absl::Status parse_rays(const v1::Rays& rays, VisibilityQuery& query) {
  const std::size_t n = query.from.size();
  LUCERNA_ASSIGN_OR_RETURN(query.directions,
                           check_triples("rays.directions", rays.directions(), n, "rays", false));
  const auto lengths = static_cast<std::size_t>(rays.lengths_m_size());
  if (lengths != 0 && lengths != n) {
    return bad_length("rays.lengths_m", lengths, n,
                      fmt::format("one for each of {} rays, or none", n));
  }
  query.lengths_m = view(rays.lengths_m());
  return absl::OkStatus();
}

/// Whether light may arrive in part.
bool is_partial(const Scene& scene, const VisibilityQuery& query) {
  return Transmittance(scene, query.thin_glass).is_partial();
}

absl::StatusOr<VisibilityQuery> parse(const CallContext& context, const Scene& scene,
                                      const v1::TestVisibilityRequest& request) {
  VisibilityQuery query;
  LUCERNA_ASSIGN_OR_RETURN(const Methods methods, check_methods(request.accuracy()));
  query.thin_glass = methods.thin_glass;
  const bool segments = request.has_segments();
  if (!segments && !request.has_rays()) {
    return bad_field("between", "unset", "segments or rays");
  }
  LUCERNA_ASSIGN_OR_RETURN(
      query.from, check_points(context, segments ? "segments.from" : "rays.from",
                               segments ? request.segments().from() : request.rays().from()));
  const std::size_t n = query.from.size();
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, segments ? "segments" : "rays", n,
                                            answer_size(request, is_partial(scene, query))));
  LUCERNA_RETURN_IF_ERROR(segments ? parse_segments(context, request.segments(), query)
                                   : parse_rays(request.rays(), query));
  LUCERNA_ASSIGN_OR_RETURN(query.time_s, check_time(request.time_s()));
  LUCERNA_ASSIGN_OR_RETURN(query.normals,
                           check_triples("normals", request.normals(), n, "items", true));
  LUCERNA_ASSIGN_OR_RETURN(
      query.position_error_m,
      check_position_error(request.has_position_error_m(), request.position_error_m()));
  return query;
}

}  // namespace

Prepared handle_test_visibility(const CallContext& context,
                                const v1::TestVisibilityRequest& request,
                                v1::TestVisibilityResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const VisibilityQuery query, parse(context, *scene, request));
  const std::size_t n = query.from.size();
  const auto run = [scene, query, n, response](const std::stop_token& stop) {
    response->set_count(static_cast<std::uint32_t>(n));
    const VisibilityAnswer answer{
        .visible = fill_bits(response->mutable_visible(), n),
        .transmittance =
            is_partial(*scene, query) ? fill(response->mutable_transmittance(), 3 * n) : nullptr,
        .status = fill(response->mutable_status(), n)};
    return finish_batch(response, test_visibility(*scene, query, answer, stop));
  };
  return batch_task(seconds_of(n, kRaySeconds), n, response, run);
}

}  // namespace lucerna::rpc
