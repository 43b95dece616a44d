// EstimateIrradiance.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "server/estimate/queries/irradiance.h"
#include "server/estimate/queries/queries.h"
#include "server/estimate/queries/spectral_values.h"
#include "server/estimate/queries/visibility.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/estimate_arrays.h"
#include "server/rpc/messages/requested_methods.h"
#include "server/rpc/messages/stop_rule.h"
#include "server/runtime/denormals.h"
#include "server/runtime/time_budget.h"

namespace lucerna::rpc {
namespace {

// Processor time [s], rounded up from what one core took on the reference scenes.
constexpr double kDirectSampleSeconds = 2e-6;
constexpr double kPathSampleSeconds = 8e-6;
constexpr double kFirstShaftsSeconds = 1e-3;
constexpr double kLookUpSeconds = 200e-9;  // a spectrum at a wavelength
constexpr std::uint32_t kIrradianceSamples = 256;

/// Points with neighbouring numbers, which are estimated together.
struct Run {
  std::size_t begin;
  std::vector<IrradiancePoint> points;
};

struct IrradianceWork {
  std::shared_ptr<const Scene> scene;
  PointArray receivers;
  std::span<const float> normals;
  std::optional<float> position_error_m;
  StopRule stop_rule;
  std::uint32_t most_samples = 0;  ///< with a time budget: so many can be asked for by number
  IrradianceSettings settings;

  absl::Status operator()(const std::stop_token& stop,
                          v1::EstimateIrradianceResponse* response) const;

 private:
  using Results = std::vector<IrradianceResult>;

  std::vector<Run> runs(int* status) const;
  /// Of all runs; nothing where it was stopped.
  std::optional<Results> estimate(const std::vector<Run>& runs, std::uint32_t samples_per_block,
                                  const std::stop_token& stop) const;
  template <typename Message>
  EstimateArrays arrays(std::size_t n, float* rgb, float* zero_bound, Message* to) const;
};

std::vector<Run> IrradianceWork::runs(int* status) const {
  const ToScene to_scene(*scene, receivers, position_error_m);
  std::vector<Run> all;
  bool joins = false;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    ScenePoint p = to_scene(i);
    const Vec3<float> normal = triple(normals, i);
    ItemResult result = p.result;
    if (!is_direction(normal)) result = ItemResult::kInvalidInput;
    if (result == ItemResult::kOk && !position_error_m)
      p = on_surface(*scene, p, normalized(normal), settings.time_s);
    status[i] = static_cast<int>(result);
    if (result == ItemResult::kOk) {
      if (!joins) all.push_back({i, {}});
      all.back().points.push_back({p.position, {p.error, p.error, p.error}, normalized(normal)});
    }
    joins = result == ItemResult::kOk;
  }
  return all;
}

std::optional<IrradianceWork::Results> IrradianceWork::estimate(const std::vector<Run>& runs,
                                                                std::uint32_t samples_per_block,
                                                                const std::stop_token& stop) const {
  Results results;
  for (const Run& run : runs) {
    IrradianceSettings of_run = settings;
    of_run.first_item += run.begin;
    of_run.samples_per_block = samples_per_block;
    results.push_back(lucerna::estimate_irradiance(*scene, run.points, of_run, stop));
    if (results.back().stopped) return std::nullopt;
  }
  return results;
}

template <typename Message>
EstimateArrays IrradianceWork::arrays(std::size_t n, float* rgb, float* zero_bound,
                                      Message* to) const {
  float* const illuminance = fill(to->mutable_illuminance_lx(), n);
  if (settings.block_count == 1) return {rgb, illuminance, nullptr, nullptr, nullptr, zero_bound};
  return {rgb,
          illuminance,
          fill(to->mutable_standard_error_lx(), n),
          fill(to->mutable_lower_lx(), n),
          fill(to->mutable_upper_lx(), n),
          zero_bound};
}

absl::Status IrradianceWork::operator()(const std::stop_token& stop,
                                        v1::EstimateIrradianceResponse* response) const {
  const DenormalsAreZero denormals;
  const std::size_t n = receivers.size();
  const std::size_t lights = scene->lights().size();
  int* const status = fill(response->mutable_status(), n);
  const std::vector<Run> all = runs(status);

  std::uint32_t samples_per_block = settings.samples_per_block;
  std::optional<Results> results;
  if (stop_rule.time_budget_s) {
    std::tie(results, samples_per_block) =
        within_time(*stop_rule.time_budget_s, most_samples / settings.block_count, stop,
                    [&](std::uint32_t each, const std::stop_token& in_time) {
                      return estimate(all, each, in_time);
                    });
  } else {
    results = estimate(all, samples_per_block, stop);
  }
  if (!results) return absl::CancelledError("stopped");

  const EstimateArrays total = arrays(n, fill(response->mutable_irradiance_lx(), 3 * n),
                                      fill(response->mutable_zero_bound_lx(), n), response);
  std::vector<EstimateArrays> shares;
  if (settings.per_light) {
    for (const SceneLight& light : scene->lights()) {
      v1::LightShare* share = response->add_shares();
      share->set_light_id(light.id);
      shares.push_back(arrays(n, nullptr, nullptr, share));
    }
  }
  const std::size_t wavelengths = settings.wavelengths_nm.size();
  float* const spectral = fill(response->mutable_spectral_irradiance(), n * wavelengths);
  float* const spectral_error =
      settings.block_count > 1 ? fill(response->mutable_spectral_standard_error(), n * wavelengths)
                               : nullptr;
  std::uint32_t* samples = nullptr;
  std::uint64_t* rays = nullptr;
  float* time_s = nullptr;
  if (settings.target) {
    v1::ItemCosts* costs = response->mutable_item_costs();
    samples = fill(costs->mutable_samples(), n);
    rays = fill(costs->mutable_rays(), n);
    time_s = fill(costs->mutable_time_s(), n);
  }
  WorkCounts work;
  std::uint64_t most = std::uint64_t{samples_per_block} * settings.block_count;
  if (settings.target) most = 0;
  for (std::size_t r = 0; r < all.size(); ++r) {
    const IrradianceResult& estimates = (*results)[r];
    work += estimates.work;
    for (std::size_t k = 0; k < all[r].points.size(); ++k) {
      const std::size_t i = all[r].begin + k;
      const auto at_wavelengths = [&](const std::vector<double>& values, float* to) {
        return to == nullptr ||
               store_spectral({values.data() + k * wavelengths, wavelengths}, to + i * wavelengths);
      };
      bool fits = total.put(i, estimates.points[k]);
      for (std::size_t l = 0; l < shares.size(); ++l)
        fits &= shares[l].put(i, estimates.per_light[k * lights + l]);
      fits = fits && at_wavelengths(estimates.spectral, spectral) &&
             at_wavelengths(estimates.spectral_error, spectral_error);
      if (settings.target) {
        const PointCost& cost = estimates.costs[k];
        most = std::max(most, cost.samples);
        samples[i] = static_cast<std::uint32_t>(cost.samples);
        rays[i] = cost.rays;
        time_s[i] = static_cast<float>(cost.time_s);
      }
      if (fits) continue;
      total.clear(i);
      for (const EstimateArrays& share : shares) share.clear(i);
      for (float* const array : {spectral, spectral_error})
        if (array != nullptr) std::fill_n(array + i * wavelengths, wavelengths, 0.0F);
      status[i] = static_cast<int>(ItemResult::kOutOfRange);
    }
  }
  response->set_samples(static_cast<std::uint32_t>(most));
  set_counts(response->mutable_cost(), work);
  drop_if_all_ok(response->mutable_status());
  return absl::OkStatus();
}

}  // namespace

Prepared estimate_irradiance(const Context& context, const v1::EstimateIrradianceRequest& request,
                             v1::EstimateIrradianceResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  IrradianceWork work;
  work.scene = *scene;
  const auto receivers = check_points(context, "receivers", request.receivers());
  if (!receivers.ok()) return receivers.status();
  work.receivers = *receivers;
  const std::size_t n = receivers->size();
  if (auto s = check_triples("normals", request.normals(), n, "receivers", false); !s.ok()) {
    return s;
  }
  work.normals = view(request.normals());
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  const auto wavelengths = check_wavelengths(request.wavelengths_nm());
  if (!wavelengths.ok()) return wavelengths.status();
  if (!wavelengths->empty() && !(request.has_bounces() && request.bounces() == 0)) {
    return bad_field("bounces",
                     request.has_bounces() ? fmt::format("{}", request.bounces()) : "unset",
                     "0 with wavelengths_nm, as surfaces have a colour and no spectrum");
  }
  work.settings.wavelengths_nm = *wavelengths;
  const auto error =
      check_position_error(request.has_position_error_m(), request.position_error_m());
  if (!error.ok()) return error.status();
  work.position_error_m = *error;
  const auto rule = check_stop_rule(context, request.accuracy(), kIrradianceSamples);
  if (!rule.ok()) return rule.status();
  work.stop_rule = *rule;
  work.most_samples = context.limits.max_samples;
  if (auto s = check_answer_size(context, "receivers", n,
                                 answer_size(request, (*scene)->lights().size()));
      !s.ok()) {
    return s;
  }
  work.settings.seed = request.seed().seed();
  work.settings.first_item = request.seed().first_item();
  work.settings.block_count = rule->samples > 0 ? replicates_of(rule->samples) : kReplicates;
  work.settings.samples_per_block = rule->samples / work.settings.block_count;
  work.settings.target = rule->target;
  if (request.has_bounces()) work.settings.bounces = request.bounces();
  work.settings.per_light = request.per_light();
  work.settings.time_s = request.time_s();
  const auto methods = check_methods(request.accuracy());
  if (!methods.ok()) return methods.status();
  work.settings.methods = *methods;

  Task task;
  const bool direct = work.settings.bounces == 0U;
  const double lights =
      work.settings.per_light ? static_cast<double>((*scene)->lights().size()) : 8;
  const std::uint64_t samples = rule->target ? rule->target->max_samples : rule->samples;
  task.predicted_s = static_cast<double>(n) * static_cast<double>(samples) *
                     (direct ? kDirectSampleSeconds : kPathSampleSeconds) * std::max(1.0, lights);
  if (rule->time_budget_s) task.predicted_s = *rule->time_budget_s;
  task.predicted_s += first_use_seconds(**scene, work.settings.methods);
  // Light is told by spectrum: each of them is looked up once, and is a value of each point.
  const double spectra = static_cast<double>((*scene)->spectra().size() + 1);
  task.predicted_s += spectra * static_cast<double>(wavelengths->size()) *
                      (kLookUpSeconds + static_cast<double>(n) * kWavelengthSeconds);
  // Whoever is first has the shafts made: not a thread of gRPC's.
  if ((*scene)->has_visible_lights() && work.settings.methods.closed_forms != ClosedForms::kOff)
    task.predicted_s += kFirstShaftsSeconds;
  task.cost = response->mutable_cost();
  task.run = [work, response](const std::stop_token& stop) { return work(stop, response); };
  return task;
}

}  // namespace lucerna::rpc
