// SampleLe, PdfLe and Le.
#include "proto/common/status_macros.h"
#include "server/estimate/queries/emission_queries.h"
#include "server/estimate/queries/predicted_time.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/randomness.h"
#include "server/rpc/messages/requested_methods.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<LeQuery> parse(const Context& context, const Scene& scene,
                              const v1::LeRequest& request) {
  LeQuery query;
  LUCERNA_ASSIGN_OR_RETURN(query.points, check_points(context, "points", request.points()));
  const std::size_t n = query.points.size();
  LUCERNA_RETURN_IF_ERROR(check_triples("directions", request.directions(), n, "points", false));
  query.directions = view(request.directions());
  LUCERNA_ASSIGN_OR_RETURN(query.light, find_light_if_named(scene, request));
  LUCERNA_RETURN_IF_ERROR(check_time(request.has_time_s(), request.time_s()));
  query.time_s = request.time_s();
  LUCERNA_ASSIGN_OR_RETURN(query.wavelengths_nm, check_wavelengths(request.wavelengths_nm()));
  LUCERNA_RETURN_IF_ERROR(check_grey_media(scene, query.wavelengths_nm));
  LUCERNA_ASSIGN_OR_RETURN(const Methods methods, check_methods(request.accuracy()));
  query.thin_glass = methods.thin_glass;
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "points", n, answer_size(request)));
  return query;
}

absl::StatusOr<SampleLeQuery> parse(const Context& context, const Scene& scene,
                                    const v1::SampleLeRequest& request) {
  SampleLeQuery query;
  query.rays = request.count();
  if (query.rays > context.limits.max_batch_items) {
    return over_limit("count", query.rays, context.limits.max_batch_items);
  }
  LUCERNA_ASSIGN_OR_RETURN(query.light, find_light_if_named(scene, request));
  LUCERNA_ASSIGN_OR_RETURN(const Randomness randomness,
                           check_randomness(request, {.samples = query.rays,
                                                      .per_sample = 4,
                                                      .light_named = names_light(request),
                                                      .of = "rays"}));
  query.seed = randomness.seed;
  query.u = randomness.u;
  query.u_light = randomness.u_light;
  LUCERNA_RETURN_IF_ERROR(check_time(request.has_time_s(), request.time_s()));
  query.time_s = request.time_s();
  LUCERNA_ASSIGN_OR_RETURN(query.wavelengths_nm, check_wavelengths(request.wavelengths_nm()));
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "count", query.rays, answer_size(request)));
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

Prepared le(const Context& context, const v1::LeRequest& request, v1::LeResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const LeQuery query, parse(context, *scene, request));
  Task task;
  task.predicted_s = le_seconds(query.points.size(), query.wavelengths_nm.size());
  task.items = query.points.size();
  task.cost = response->mutable_cost();
  task.run = [scene, query, response](const std::stop_token& stop) {
    const LeAnswer answer = sized_arrays(query, response);
    set_counts(response->mutable_cost(), lucerna::le(*scene, query, answer, stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

Prepared sample_le(const Context& context, const v1::SampleLeRequest& request,
                   v1::SampleLeResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const SampleLeQuery query, parse(context, *scene, request));
  Task task;
  task.predicted_s = sample_le_seconds(query.rays, query.wavelengths_nm.size());
  task.items = query.rays;
  task.cost = response->mutable_cost();
  task.run = [scene, query, &request, response](const std::stop_token& stop) -> absl::Status {
    LUCERNA_RETURN_IF_ERROR(check_u(request.u()));
    set(scene->origin(), response->mutable_points()->mutable_origin_m());
    const SampleLeAnswer answer = sized_arrays(query, response);
    set_counts(response->mutable_cost(), lucerna::sample_le(*scene, query, answer, stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

Prepared pdf_le(const Context& context, const v1::PdfLeRequest& request,
                v1::PdfLeResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const auto scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(const PointArray points,
                           check_points(context, "points", request.points()));
  const std::size_t n = points.size();
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "points", n, answer_size(request)));
  LUCERNA_RETURN_IF_ERROR(check_triples("directions", request.directions(), n, "points", false));
  LUCERNA_ASSIGN_OR_RETURN(const std::uint32_t light, find_required_light(*scene, request));
  LUCERNA_RETURN_IF_ERROR(check_time(request.has_time_s(), request.time_s()));
  Task task;
  task.predicted_s = pdf_seconds(scene->lights()[light].light, n);
  task.items = n;
  task.cost = response->mutable_cost();
  task.run = [scene, light, points, n, &request, response](const std::stop_token& stop) {
    lucerna::pdf_le(*scene, light, points, view(request.directions()), request.time_s(),
                    fill(response->mutable_pdf_position_per_m2(), n),
                    fill(response->mutable_pdf_direction_per_sr(), n),
                    fill(response->mutable_status(), n), stop);
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
