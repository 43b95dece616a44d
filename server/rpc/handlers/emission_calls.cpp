// SampleLe, PdfLe and Le.
#include "server/estimate/queries/emission_queries.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/randomness.h"

namespace lucerna::rpc {
namespace {

// Processor time of one ray [s], rounded up from what one core took on the reference scenes.
constexpr double kLeSeconds = 1.5e-6;
constexpr double kEmissionSeconds = 500e-9;

void set_origin(const Scene& scene, v1::Points* points) {
  points->mutable_origin_m()->set_x(scene.origin().x);
  points->mutable_origin_m()->set_y(scene.origin().y);
  points->mutable_origin_m()->set_z(scene.origin().z);
}

SampleLeAnswer make_room(const SampleLeQuery& query, v1::SampleLeResponse* r) {
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
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  LeQuery query;
  const auto points = check_points(context, "points", request.points());
  if (!points.ok()) return points.status();
  query.points = *points;
  const std::size_t n = points->size();
  if (auto s = check_triples("directions", request.directions(), n, "points", false); !s.ok()) {
    return s;
  }
  query.directions = view(request.directions());
  const auto light = find_light_if_named(**scene, request);
  if (!light.ok()) return light.status();
  query.light = *light;
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  const auto wavelengths = check_wavelengths(request.wavelengths_nm());
  if (!wavelengths.ok()) return wavelengths.status();
  query.wavelengths_nm = *wavelengths;
  if (auto s = check_answer_size(context, "points", n, answer_size(request)); !s.ok()) return s;
  query.time_s = request.time_s();

  Task task;
  task.predicted_s =
      static_cast<double>(n) *
      (kLeSeconds + kWavelengthSeconds * static_cast<double>(query.wavelengths_nm.size()));
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, n, response](const std::stop_token& stop) {
    const LeAnswer answer{.radiance_cd_m2 = fill(response->mutable_radiance_cd_m2(), 3 * n),
                          .light_ids = fill(response->mutable_light_ids(), n),
                          .status = fill(response->mutable_status(), n),
                          .spectral_radiance = fill(response->mutable_spectral_radiance(),
                                                    n * query.wavelengths_nm.size())};
    set_counts(response->mutable_cost(), lucerna::le(*scene, query, answer, stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

Prepared sample_le(const Context& context, const v1::SampleLeRequest& request,
                   v1::SampleLeResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  SampleLeQuery query;
  query.rays = request.count();
  if (query.rays > context.limits.max_batch_items) {
    return over_limit("count", query.rays, context.limits.max_batch_items);
  }
  const auto light = find_light_if_named(**scene, request);
  if (!light.ok()) return light.status();
  query.light = *light;
  const auto randomness = check_randomness(request, {.samples = query.rays,
                                                     .per_sample = 4,
                                                     .light_named = request.has_light_id(),
                                                     .of = "rays"});
  if (!randomness.ok()) return randomness.status();
  query.seed = randomness->seed;
  query.u = randomness->u;
  query.u_light = randomness->u_light;
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  const auto wavelengths = check_wavelengths(request.wavelengths_nm());
  if (!wavelengths.ok()) return wavelengths.status();
  query.wavelengths_nm = *wavelengths;
  if (auto s = check_answer_size(context, "count", query.rays, answer_size(request)); !s.ok()) {
    return s;
  }
  query.time_s = request.time_s();

  Task task;
  task.predicted_s =
      query.rays *
      (kEmissionSeconds + kWavelengthSeconds * static_cast<double>(query.wavelengths_nm.size()));
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, &request, response](const std::stop_token& stop) {
    if (auto s = check_u(request.u()); !s.ok()) return s;
    set_origin(*scene, response->mutable_points());
    const SampleLeAnswer answer = make_room(query, response);
    set_counts(response->mutable_cost(), lucerna::sample_le(*scene, query, answer, stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

Prepared pdf_le(const Context& context, const v1::PdfLeRequest& request,
                v1::PdfLeResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  const auto points = check_points(context, "points", request.points());
  if (!points.ok()) return points.status();
  const std::size_t n = points->size();
  if (auto s = check_answer_size(context, "points", n, answer_size(request)); !s.ok()) return s;
  if (auto s = check_triples("directions", request.directions(), n, "points", false); !s.ok()) {
    return s;
  }
  const auto light = find_required_light(**scene, request.light_id());
  if (!light.ok()) return light.status();
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;

  Task task;
  task.predicted_s = static_cast<double>(n) * pdf_seconds((*scene)->lights()[*light].light);
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, light = *light, points = *points, n, &request,
              response](const std::stop_token& stop) {
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
