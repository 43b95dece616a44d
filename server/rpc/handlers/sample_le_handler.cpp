#include "server/rpc/handlers/sample_le_handler.h"

#include "proto/common/status_macros.h"
#include "server/queries/emission_queries.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/randomness.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<SampleLeQuery> parse(const CallContext& context, const Scene& scene,
                                    const v1::SampleLeRequest& request) {
  SampleLeQuery query;
  query.rays = request.count();
  LUCERNA_RETURN_IF_ERROR(check_limit("count", query.rays, context.limits.max_batch_items));
  LUCERNA_ASSIGN_OR_RETURN(query.light, find_light_if_named(scene, request));
  LUCERNA_RETURN_IF_ERROR(put_randomness(
      request,
      {.samples = query.rays, .per_sample = 4, .light_named = names_light(request), .of = "rays"},
      query));
  LUCERNA_ASSIGN_OR_RETURN(query.time_s, check_time(request.time_s()));
  LUCERNA_ASSIGN_OR_RETURN(query.wavelengths_nm, check_wavelengths(request.wavelengths_nm()));
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "count", query.rays, answer_size(request)));
  return query;
}

SampleLeAnswer sized_arrays(const SampleLeQuery& query, v1::SampleLeResponse* r) {
  const std::size_t n = query.rays;
  const bool chosen = !query.light;
  return {.offsets_m = fill(r->mutable_points()->mutable_offsets_m(), 3 * n),
          .directions = fill(r->mutable_directions(), 3 * n),
          .light_normals = fill(r->mutable_light_normals(), 3 * n),
          .value = fill(r->mutable_value(), 3 * n),
          .pdf_position_per_m2 = fill(r->mutable_pdf_position_per_m2(), n),
          .pdf_direction_per_sr = fill(r->mutable_pdf_direction_per_sr(), n),
          .light_ids = chosen ? fill(r->mutable_light_ids(), n) : nullptr,
          .selection_probability = chosen ? fill(r->mutable_selection_probability(), n) : nullptr,
          .status = fill(r->mutable_status(), n),
          .spectral_value = fill(r->mutable_spectral_value(), n * query.wavelengths_nm.size())};
}

}  // namespace

Prepared handle_sample_le(const CallContext& context, const v1::SampleLeRequest& request,
                          v1::SampleLeResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const SampleLeQuery query, parse(context, *scene, request));
  const auto run = [scene, query, &request, response](const std::stop_token& stop) -> absl::Status {
    LUCERNA_RETURN_IF_ERROR(check_u(request.u()));
    set(scene->origin(), response->mutable_points()->mutable_origin_m());
    return finish_batch(response, sample_le(*scene, query, sized_arrays(query, response), stop));
  };
  constexpr double kEmissionSeconds = 500e-9;
  const double seconds = seconds_of(query.rays, kEmissionSeconds, query.wavelengths_nm.size());
  return batch_task(seconds, query.rays, response, run);
}

}  // namespace lucerna::rpc
