#include "server/rpc/handlers/estimate_irradiance_handler.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/estimate/missed_light.h"
#include "server/queries/queries.h"
#include "server/queries/receiver_irradiance.h"
#include "server/queries/visibility.h"
#include "server/rpc/handlers/predicted_time.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/estimate_arrays.h"
#include "server/rpc/messages/requested_accuracy.h"
#include "server/runtime/denormals.h"
#include "server/runtime/time_budget.h"
#include "server/visibility/inside_solid.h"
#include "server/visibility/smooth_surfaces.h"

namespace lucerna::rpc {
namespace {

struct IrradianceQuery {
  std::shared_ptr<const Scene> scene;
  PointArray receivers;
  std::span<const float> normals;
  std::optional<float> position_error_m;
  StopRule stop_rule;
  std::uint32_t most_samples = 0;  ///< with a time budget: the most that a request may name
  IrradianceSettings settings;
};

/// The receivers of a request that are OK, with their numbers in it.
struct Receivers {
  std::vector<std::uint32_t> numbers;
  std::vector<IrradiancePoint> points;
};

absl::StatusOr<std::span<const double>> parse_wavelengths(
    const v1::EstimateIrradianceRequest& request) {
  LUCERNA_ASSIGN_OR_RETURN(const std::span<const double> wavelengths_nm,
                           check_wavelengths(request.wavelengths_nm()));
  if (!wavelengths_nm.empty() && !(request.has_bounces() && request.bounces() == 0)) {
    return bad_field("bounces",
                     request.has_bounces() ? fmt::format("{}", request.bounces()) : "unset",
                     "0 with wavelengths_nm, since surfaces have a colour and no spectrum");
  }
  return wavelengths_nm;
}

absl::StatusOr<IrradianceQuery> parse(const CallContext& context,
                                      const v1::EstimateIrradianceRequest& request) {
  IrradianceQuery query;
  LUCERNA_ASSIGN_OR_RETURN(query.scene, find_scene(context, request.scene_id()));
  LUCERNA_ASSIGN_OR_RETURN(query.receivers,
                           check_points(context, "receivers", request.receivers()));
  const std::size_t n = query.receivers.size();
  LUCERNA_ASSIGN_OR_RETURN(query.normals,
                           check_triples("normals", request.normals(), n, "receivers", false));
  LUCERNA_ASSIGN_OR_RETURN(query.settings.time_s, check_time(request.time_s()));
  LUCERNA_ASSIGN_OR_RETURN(query.settings.wavelengths_nm, parse_wavelengths(request));
  LUCERNA_RETURN_IF_ERROR(check_grey_media(*query.scene, query.settings.wavelengths_nm));
  LUCERNA_ASSIGN_OR_RETURN(
      query.position_error_m,
      check_position_error(request.has_position_error_m(), request.position_error_m()));
  LUCERNA_ASSIGN_OR_RETURN(query.stop_rule,
                           check_stop_rule(context, request.accuracy(), kIrradianceSamples));
  query.most_samples = context.limits.max_samples;
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "receivers", n,
                                            answer_size(request, query.scene->lights().size())));
  LUCERNA_ASSIGN_OR_RETURN(query.settings.methods, check_methods(request.accuracy()));

  IrradianceSettings& settings = query.settings;
  const StopRule& rule = query.stop_rule;
  settings.seed = request.seed().seed();
  settings.first_item = request.seed().first_item();
  settings.block_count = rule.samples > 0 ? blocks_of(rule.samples) : kDefaultBlocks;
  settings.samples_per_block = rule.samples / settings.block_count;
  settings.target = rule.target;
  if (request.has_bounces()) settings.bounces = request.bounces();
  settings.per_light = request.per_light();
  return query;
}

double predicted_seconds(const IrradianceQuery& query) {
  constexpr double kDirectSampleSeconds = 2e-6, kPathSampleSeconds = 8e-6;
  constexpr double kSpectrumSeconds = 200e-9;  // a spectrum at a wavelength
  // With the time to make the shafts of a scene, a thread of gRPC does not make them.
  constexpr double kShaftsSeconds = 1e-3;
  // Lights that a sample visits, unless each light has its own share.
  constexpr double kVisitedLights = 8;
  const Scene& scene = *query.scene;
  const IrradianceSettings& settings = query.settings;
  const StopRule& rule = query.stop_rule;
  const std::size_t n = query.receivers.size();
  // Each spectrum is looked up once at each wavelength, and has a value there at each point.
  const std::size_t spectra = scene.lights().spectra().size() + 1;
  double seconds = first_use_seconds(scene, settings.methods) +
                   seconds_of(spectra * settings.wavelengths_nm.size(),
                              kSpectrumSeconds + seconds_of(n, kWavelengthSeconds));
  if (scene.lights().has_visible() && settings.methods.closed_forms != ClosedForms::kOff)
    seconds += kShaftsSeconds;
  if (rule.time_budget_s) return seconds + *rule.time_budget_s;
  const auto samples = static_cast<double>(rule.target ? rule.target->max_samples : rule.samples);
  const double lights =
      settings.per_light ? static_cast<double>(scene.lights().size()) : kVisitedLights;
  return seconds +
         seconds_of(n, samples *
                           (settings.bounces == 0U ? kDirectSampleSeconds : kPathSampleSeconds) *
                           std::max(1.0, lights));
}

/// Sets the status of each receiver.  Returns those that are OK.
Receivers receivers_of(const IrradianceQuery& query, int* status) {
  const Scene& scene = *query.scene;
  const ToScene to_scene(scene, query.receivers, query.position_error_m);
  Receivers receivers;
  for (std::size_t i = 0; i < query.receivers.size(); ++i) {
    ScenePoint p = to_scene(i);
    const Vec3f normal = triple(query.normals, i);
    ItemResult result = p.result;
    if (!is_direction(normal)) result = ItemResult::kInvalidInput;
    status[i] = static_cast<int>(result);
    if (result != ItemResult::kOk) continue;
    if (!query.position_error_m)
      p = on_surface(scene, p, normalized(normal), query.settings.time_s);
    receivers.numbers.push_back(static_cast<std::uint32_t>(i));
    receivers.points.push_back({p.position, {p.error, p.error, p.error}, normalized(Vec3(normal))});
  }
  return receivers;
}

/// Writes the estimates into the arrays of the response.
void put_estimates(const IrradianceQuery& query, const Receivers& receivers,
                   const IrradianceResult& estimates, v1::EstimateIrradianceResponse* response) {
  const std::size_t n = query.receivers.size();
  const bool has_errors = query.settings.block_count > 1;
  EstimateArrays total = estimate_arrays(n, has_errors, response);
  total.rgb = fill(response->mutable_irradiance_lx(), 3 * n);
  total.zero_bound = fill(response->mutable_zero_bound_lx(), n);
  std::vector<EstimateArrays> shares;
  for (const SceneLight& light : query.scene->lights()) {
    if (!query.settings.per_light) break;
    v1::LightShare* share = response->add_shares();
    share->set_light_id(light.id);
    shares.push_back(estimate_arrays(n, has_errors, share));
  }
  const std::size_t wavelengths = query.settings.wavelengths_nm.size();
  const SpectralArrays spectra{
      wavelengths, fill(response->mutable_spectral_irradiance(), n * wavelengths),
      has_errors ? fill(response->mutable_spectral_standard_error(), n * wavelengths) : nullptr};
  for (std::size_t k = 0; k < receivers.numbers.size(); ++k) {
    const std::uint32_t i = receivers.numbers[k];
    bool fits = total.put(i, estimates.points[k]) &&
                spectra.put(i, estimates.spectral, estimates.spectral_error, k);
    for (std::size_t l = 0; l < shares.size(); ++l)
      fits = fits && shares[l].put(i, estimates.per_light[k * shares.size() + l]);
    if (fits) continue;
    total.clear(i);
    spectra.clear(i);
    for (const EstimateArrays& share : shares) share.clear(i);
    response->mutable_status()->Set(static_cast<int>(i), static_cast<int>(ItemResult::kOutOfRange));
  }
}

/// Sets the number of samples.  With a target error, sets the cost of each receiver.
void put_samples(const IrradianceQuery& query, const Receivers& receivers,
                 const IrradianceResult& estimates, std::uint32_t samples_per_block,
                 v1::EstimateIrradianceResponse* response) {
  std::uint64_t most = std::uint64_t{samples_per_block} * query.settings.block_count;
  if (query.settings.target) {
    most = 0;
    const std::size_t n = query.receivers.size();
    std::uint32_t* const samples = fill(response->mutable_item_costs()->mutable_samples(), n);
    std::uint64_t* const rays = fill(response->mutable_item_costs()->mutable_rays(), n);
    float* const time_s = fill(response->mutable_item_costs()->mutable_time_s(), n);
    for (std::size_t k = 0; k < receivers.numbers.size(); ++k) {
      const std::uint32_t i = receivers.numbers[k];
      const PointCost& cost = estimates.costs[k];
      most = std::max(most, cost.samples);
      samples[i] = static_cast<std::uint32_t>(cost.samples);
      rays[i] = cost.rays;
      time_s[i] = static_cast<float>(cost.time_s);
    }
  }
  response->set_samples(static_cast<std::uint32_t>(most));
}

/// Sets MAY_MISS_LIGHT for receivers whose answers may miss light, with its bounds.
void mark_missed_light(const IrradianceQuery& query, const Receivers& receivers,
                       const IrradianceResult& estimates,
                       v1::EstimateIrradianceResponse* response) {
  fill(response->mutable_unsampled_bound_lx(), query.receivers.size());
  bool by_way = false, outdoors = false;
  for (std::size_t k = 0; k < receivers.numbers.size(); ++k) {
    const auto i = static_cast<int>(receivers.numbers[k]);
    const MissedLight& missed = estimates.points[k].missed;
    if (missed.kind == MissedLight::Kind::kNone ||
        response->status(i) != static_cast<int>(ItemResult::kOk))
      continue;
    response->mutable_status()->Set(i, static_cast<int>(ItemResult::kMayMissLight));
    response->set_unsampled_bound_lx(i, held_as_float(missed.bound_lx));
    by_way |= missed.kind == MissedLight::Kind::kByWay;
    outdoors |= missed.kind == MissedLight::Kind::kOutdoors;
  }
  constexpr std::size_t kMostNamed = 3;
  if (outdoors) {
    const std::vector<std::uint32_t> portals = portal_lights(*query.scene);
    for (std::size_t l = 0; l < std::min(kMostNamed, portals.size()); ++l)
      response->add_missed_surfaces(
          text_of(query.scene->lights().source_of(query.scene->lights()[portals[l]])) +
          " (a portal)");
  }
  if (!by_way) return;
  const auto unsolved = smooth_surfaces(*query.scene).unsolved();
  for (std::size_t s = 0; s < std::min(kMostNamed, unsolved.size()); ++s)
    response->add_missed_surfaces(text_of(unsolved[s].where));
}

/// Sets INSIDE_SOLID for receivers that get no light and lie inside of a solid.
void mark_inside_solids(const IrradianceQuery& query, const Receivers& receivers,
                        const IrradianceResult& estimates, const std::stop_token& stop,
                        int* status) {
  std::vector<SurfaceHit> dark;
  std::vector<std::uint32_t> numbers;
  for (std::size_t k = 0; k < receivers.numbers.size(); ++k) {
    const std::uint32_t i = receivers.numbers[k];
    const bool is_ok = status[i] == static_cast<int>(ItemResult::kOk);
    if (!is_ok || !estimates.points[k].irradiance_lx.is_black()) continue;
    dark.push_back(surface_at(receivers.points[k], query.settings.time_s));
    numbers.push_back(i);
  }
  const std::vector<std::uint8_t> inside = inside_solids(*query.scene, dark, stop);
  for (std::size_t d = 0; d < inside.size(); ++d)
    if (inside[d] != 0) status[numbers[d]] = static_cast<int>(ItemResult::kInsideSolid);
}

absl::Status answer(const IrradianceQuery& query, const std::stop_token& stop,
                    v1::EstimateIrradianceResponse* response) {
  const DenormalsAreZero denormals;
  int* const status = fill(response->mutable_status(), query.receivers.size());
  const Receivers receivers = receivers_of(query, status);
  const auto run = [&](std::uint32_t samples_per_block,
                       const std::stop_token& s) -> std::optional<IrradianceResult> {
    IrradianceSettings settings = query.settings;
    settings.numbers = receivers.numbers;
    settings.samples_per_block = samples_per_block;
    IrradianceResult result = estimate_irradiance(*query.scene, receivers.points, settings, s);
    if (result.stopped) return std::nullopt;
    return result;
  };
  std::uint32_t samples_per_block = query.settings.samples_per_block;
  std::optional<IrradianceResult> estimates;
  if (const auto& budget_s = query.stop_rule.time_budget_s) {
    std::tie(estimates, samples_per_block) =
        within_time(*budget_s, query.most_samples / query.settings.block_count, stop, run);
  } else {
    estimates = run(samples_per_block, stop);
  }
  if (!estimates) return absl::CancelledError("stopped");

  put_estimates(query, receivers, *estimates, response);
  put_samples(query, receivers, *estimates, samples_per_block, response);
  mark_inside_solids(query, receivers, *estimates, stop, status);
  mark_missed_light(query, receivers, *estimates, response);
  return finish_batch(response, estimates->work);
}

}  // namespace

Prepared handle_estimate_irradiance(const CallContext& context,
                                    const v1::EstimateIrradianceRequest& request,
                                    v1::EstimateIrradianceResponse* response) {
  LUCERNA_ASSIGN_OR_RETURN(const IrradianceQuery query, parse(context, request));
  return batch_task(
      predicted_seconds(query), query.receivers.size(), response,
      [query, response](const std::stop_token& stop) { return answer(query, stop, response); });
}

}  // namespace lucerna::rpc
