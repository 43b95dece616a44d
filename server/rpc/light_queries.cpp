// SampleLi and PdfLi.
#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "server/queries.h"
#include "server/rpc/checks.h"
#include "server/rpc/errors.h"
#include "server/rpc/lighting.h"
#include "server/rpc/methods.h"
#include "server/rpc/randomness.h"

namespace lucerna::rpc {
namespace {

// Processor time of one item [s], rounded up from what one core took on the reference scenes.
constexpr double kSampleSeconds = 400e-9;
constexpr double kShadowRaySeconds = 1e-6;

SampleLiAnswer make_room(const SampleLiQuery& query, std::size_t n, v1::SampleLiResponse* r) {
  const bool chosen = !query.light;
  return {.value = fill(r->mutable_value(), 3 * n),
          .wi = fill(r->mutable_wi(), 3 * n),
          .distance_m = fill(r->mutable_distance_m(), n),
          .light_offsets_m = fill(r->mutable_light_offsets_m(), 3 * n),
          .light_normals = fill(r->mutable_light_normals(), 3 * n),
          .pdf_per_sr = fill(r->mutable_pdf_per_sr(), n),
          .delta = fill_bits(r->mutable_delta(), n),
          .visible = query.test_visibility ? fill_bits(r->mutable_visible(), n) : nullptr,
          .light_ids = chosen ? fill(r->mutable_light_ids(), n) : nullptr,
          .selection_probability = chosen ? fill(r->mutable_selection_probability(), n) : nullptr,
          .status = fill(r->mutable_status(), n),
          .spectral_value = fill(r->mutable_spectral_value(), n * query.wavelengths_nm.size())};
}

}  // namespace

Prepared sample_li(const Context& context, const v1::SampleLiRequest& request,
                   v1::SampleLiResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  SampleLiQuery query;
  const auto receivers = check_points(context, "receivers", request.receivers());
  if (!receivers.ok()) return receivers.status();
  query.receivers = *receivers;
  const auto samples = check_samples(context, request.accuracy(), 1);
  if (!samples.ok()) return samples.status();
  query.samples = *samples;
  const std::uint64_t n = std::uint64_t{query.samples} * query.receivers.size();
  if (n > context.limits.max_batch_items) {
    return over_limit("receivers times accuracy.samples", n, context.limits.max_batch_items);
  }
  const auto light = find_light_if_named(**scene, request);
  if (!light.ok()) return light.status();
  query.light = *light;
  const auto randomness = check_randomness(
      request,
      {.samples = n, .per_sample = 2, .light_named = request.has_light_id(), .of = "samples"});
  if (!randomness.ok()) return randomness.status();
  query.seed = randomness->seed;
  query.u = randomness->u;
  query.u_light = randomness->u_light;
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  const auto wavelengths = check_wavelengths(request.wavelengths_nm());
  if (!wavelengths.ok()) return wavelengths.status();
  query.wavelengths_nm = *wavelengths;
  if (auto s =
          check_answer_size(context, "receivers times accuracy.samples", n, answer_size(request));
      !s.ok()) {
    return s;
  }
  query.time_s = request.time_s();
  query.test_visibility = request.test_visibility();
  if (auto s =
          check_triples("normals", request.normals(), query.receivers.size(), "receivers", true);
      !s.ok()) {
    return s;
  }
  query.normals = view(request.normals());
  const auto error =
      check_position_error(request.has_position_error_m(), request.position_error_m());
  if (!error.ok()) return error.status();
  query.position_error_m = *error;
  const auto methods = check_methods(request.accuracy());
  if (!methods.ok()) return methods.status();
  query.methods = *methods;

  Task task;
  task.predicted_s = static_cast<double>(n) *
                     (kSampleSeconds + (query.test_visibility ? kShadowRaySeconds : 0) +
                      kWavelengthSeconds * static_cast<double>(query.wavelengths_nm.size()));
  if (query.test_visibility) task.predicted_s += first_use_seconds(**scene, query.methods);
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, n, &request, response](const std::stop_token& stop) {
    if (auto s = check_u(request.u()); !s.ok()) return s;
    const SampleLiAnswer answer = make_room(query, n, response);
    set_counts(response->mutable_cost(), lucerna::sample_li(*scene, query, answer, stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

Prepared pdf_li(const Context& context, const v1::PdfLiRequest& request,
                v1::PdfLiResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  const auto receivers = check_points(context, "receivers", request.receivers());
  if (!receivers.ok()) return receivers.status();
  const std::size_t n = receivers->size();
  if (auto s = check_answer_size(context, "receivers", n, answer_size(request)); !s.ok()) return s;
  if (auto s = check_triples("wi", request.wi(), n, "receivers", false); !s.ok()) return s;
  const auto light = find_required_light(**scene, request.light_id());
  if (!light.ok()) return light.status();
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  if (auto s = check_triples("normals", request.normals(), n, "receivers", true); !s.ok()) return s;
  const auto methods = check_methods(request.accuracy());
  if (!methods.ok()) return methods.status();
  const PdfLiQuery query{.light = *light,
                         .receivers = *receivers,
                         .wi = view(request.wi()),
                         .normals = view(request.normals()),
                         .area_sampling = methods->area_sampling,
                         .time_s = request.time_s()};

  Task task;
  task.predicted_s = static_cast<double>(n) * pdf_seconds((*scene)->lights()[*light].light);
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, n, response](const std::stop_token& stop) {
    lucerna::pdf_li(*scene, query, fill(response->mutable_pdf_per_sr(), n),
                    fill(response->mutable_status(), n), stop);
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
