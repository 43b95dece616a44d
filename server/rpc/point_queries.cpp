// TestVisibility and EstimateIrradiance.
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "proto/sample_blocks.h"
#include "server/denormals.h"
#include "server/queries.h"
#include "server/render.h"
#include "server/rpc/checks.h"
#include "server/rpc/errors.h"
#include "server/rpc/lighting.h"
#include "server/spectral_values.h"
#include "server/visibility.h"

namespace lucerna::rpc {
namespace {

// Processor time [s], rounded up from what one core took on the reference scenes.
constexpr double kShadowRaySeconds = 1.5e-6;
constexpr double kDirectSampleSeconds = 2e-6;
constexpr double kPathSampleSeconds = 8e-6;
constexpr double kLookUpSeconds = 200e-9;  // a spectrum at a wavelength
constexpr std::uint32_t kDefaultSamples = 256;
// Replicates of an estimate: its standard error is then known to about a fifth.
constexpr std::uint32_t kReplicates = 16;

absl::Status check_rays(const v1::Rays& rays, std::size_t n, VisibilityQuery& query) {
  if (auto s = check_triples("rays.directions", rays.directions(), n, "rays", false); !s.ok()) {
    return s;
  }
  const auto lengths = static_cast<std::size_t>(rays.lengths_m_size());
  if (lengths != 0 && lengths != n) {
    return bad_length("rays.lengths_m", lengths, n,
                      fmt::format("one for each of {} rays, or none", n));
  }
  query.directions = view(rays.directions());
  query.lengths_m = view(rays.lengths_m());
  return absl::OkStatus();
}

/// Estimates as a response holds them.
struct EstimateArrays {
  float* rgb;  // null: not wanted
  float* illuminance;
  float* standard_error;  // null: not known from a single sample
  float* zero_bound;      // null: not wanted

  /// False where a number does not fit a float; nothing is written then.
  bool put(std::size_t i, const IrradianceEstimate& e) const {
    const Rgb<float> value(e.irradiance_lx);
    const auto lux = static_cast<float>(luminance(e.irradiance_lx));
    // Channels share their samples, so their errors go together: the bound is nearly reached.
    const auto error = e.exact ? 0.0F : static_cast<float>(luminance(e.standard_error_lx));
    if (!is_finite(value) || !std::isfinite(lux)) return false;
    if (standard_error != nullptr && !std::isfinite(error)) return false;
    if (rgb != nullptr) {
      rgb[3 * i] = value.r;
      rgb[3 * i + 1] = value.g;
      rgb[3 * i + 2] = value.b;
    }
    illuminance[i] = lux;
    if (standard_error != nullptr) standard_error[i] = error;
    if (zero_bound != nullptr) {
      zero_bound[i] =
          std::min(static_cast<float>(e.zero_bound_lx), std::numeric_limits<float>::max());
    }
    return true;
  }

  void clear(std::size_t i) const {
    if (rgb != nullptr) std::fill_n(rgb + 3 * i, 3, 0.0F);
    for (float* const array : {illuminance, standard_error, zero_bound}) {
      if (array != nullptr) array[i] = 0;
    }
  }
};

struct IrradianceWork {
  std::shared_ptr<const Scene> scene;
  PointArray receivers;
  std::span<const float> normals;
  std::optional<float> position_error_m;
  IrradianceSettings settings;
  bool has_error = true;

  absl::Status operator()(const std::stop_token& stop,
                          v1::EstimateIrradianceResponse* response) const;
};

absl::Status IrradianceWork::operator()(const std::stop_token& stop,
                                        v1::EstimateIrradianceResponse* response) const {
  const DenormalsAreZero denormals;
  const std::size_t n = receivers.size();
  const std::size_t lights = scene->lights().size();
  const EstimateArrays total{fill(response->mutable_irradiance_lx(), 3 * n),
                             fill(response->mutable_illuminance_lx(), n),
                             has_error ? fill(response->mutable_standard_error_lx(), n) : nullptr,
                             fill(response->mutable_zero_bound_lx(), n)};
  std::vector<EstimateArrays> shares;
  if (settings.per_light) {
    for (const SceneLight& light : scene->lights()) {
      v1::LightShare* share = response->add_shares();
      share->set_light_id(light.id);
      shares.push_back({nullptr, fill(share->mutable_illuminance_lx(), n),
                        has_error ? fill(share->mutable_standard_error_lx(), n) : nullptr,
                        nullptr});
    }
  }
  const std::size_t wavelengths = settings.wavelengths_nm.size();
  float* const spectral = fill(response->mutable_spectral_irradiance(), n * wavelengths);
  int* const status = fill(response->mutable_status(), n);
  const ToScene to_scene(*scene, receivers, position_error_m);
  std::vector<IrradiancePoint> points;
  WorkCounts work;
  // Points keep their numbers, so each run of good ones is estimated by itself.
  for (std::size_t i = 0; i <= n; ++i) {
    ItemResult result = ItemResult::kInvalidInput;
    if (i < n) {
      ScenePoint p = to_scene(i);
      const Vec3<float> normal = triple(normals, i);
      result = p.result;
      if (!is_direction(normal)) result = ItemResult::kInvalidInput;
      if (result == ItemResult::kOk && !position_error_m) {
        p = on_surface(*scene, p, normalized(normal), settings.time_s);
      }
      status[i] = static_cast<int>(result);
      if (result == ItemResult::kOk) {
        points.push_back({p.position, {p.error, p.error, p.error}, normalized(normal)});
        continue;
      }
    }
    if (points.empty()) continue;
    const std::size_t begin = i - points.size();
    IrradianceSettings run = settings;
    run.first_item += begin;
    const IrradianceResult estimates = lucerna::estimate_irradiance(*scene, points, run, stop);
    if (estimates.stopped) return absl::CancelledError("stopped");
    work += estimates.work;
    for (std::size_t k = 0; k < points.size(); ++k) {
      bool fits = total.put(begin + k, estimates.points[k]);
      for (std::size_t l = 0; l < shares.size(); ++l) {
        fits &= shares[l].put(begin + k, estimates.per_light[k * lights + l]);
      }
      fits = fits && store_spectral({estimates.spectral.data() + k * wavelengths, wavelengths},
                                    spectral + (begin + k) * wavelengths);
      if (fits) continue;
      total.clear(begin + k);
      for (const EstimateArrays& share : shares) share.clear(begin + k);
      status[begin + k] = static_cast<int>(ItemResult::kOutOfRange);
    }
    points.clear();
  }
  response->set_samples(settings.samples_per_block * settings.block_count);
  set_counts(response->mutable_cost(), work);
  drop_if_all_ok(response->mutable_status());
  return absl::OkStatus();
}

}  // namespace

Prepared test_visibility(const Context& context, const v1::TestVisibilityRequest& request,
                         v1::TestVisibilityResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  VisibilityQuery query;
  const bool segments = request.has_segments();
  if (!segments && !request.has_rays()) {
    return bad_field("between", "unset", "segments or rays");
  }
  const auto from = check_points(context, segments ? "segments.from" : "rays.from",
                                 segments ? request.segments().from() : request.rays().from());
  if (!from.ok()) return from.status();
  query.from = *from;
  const std::size_t n = from->size();
  if (auto s = check_answer_size(context, segments ? "segments" : "rays", n, answer_size(request));
      !s.ok()) {
    return s;
  }
  if (segments) {
    const auto to = check_points(context, "segments.to", request.segments().to());
    if (!to.ok()) return to.status();
    if (to->size() != n) {
      return bad_length("segments.to.offsets_m", 3 * to->size(), 3 * n,
                        "as many as segments.from.offsets_m");
    }
    query.to = *to;
  } else if (auto s = check_rays(request.rays(), n, query); !s.ok()) {
    return s;
  }
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  if (auto s = check_triples("normals", request.normals(), n, "items", true); !s.ok()) return s;
  query.time_s = request.time_s();
  query.normals = view(request.normals());
  const auto error =
      check_position_error(request.has_position_error_m(), request.position_error_m());
  if (!error.ok()) return error.status();
  query.position_error_m = *error;

  Task task;
  task.predicted_s = static_cast<double>(n) * kShadowRaySeconds;
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, query, n, response](const std::stop_token& stop) {
    response->set_count(static_cast<std::uint32_t>(n));
    set_counts(response->mutable_cost(),
               lucerna::test_visibility(*scene, query, fill_bits(response->mutable_visible(), n),
                                        fill(response->mutable_status(), n), stop));
    drop_if_all_ok(response->mutable_status());
    return absl::OkStatus();
  };
  return task;
}

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
  const auto samples = check_samples(context, request.accuracy(), kDefaultSamples);
  if (!samples.ok()) return samples.status();
  if (auto s = check_answer_size(context, "receivers", n,
                                 answer_size(request, (*scene)->lights().size()));
      !s.ok()) {
    return s;
  }
  work.has_error = *samples > 1;
  work.settings.seed = request.seed().seed();
  work.settings.first_item = request.seed().first_item();
  work.settings.samples_per_block = default_samples_per_block(*samples, kReplicates);
  work.settings.block_count = *samples / work.settings.samples_per_block;
  if (request.has_bounces()) work.settings.bounces = request.bounces();
  work.settings.per_light = request.per_light();
  work.settings.time_s = request.time_s();
  const auto way = check_area_sampling(request.accuracy());
  if (!way.ok()) return way.status();
  work.settings.area_sampling = *way;

  Task task;
  const bool direct = work.settings.bounces == 0U;
  const double lights =
      work.settings.per_light ? static_cast<double>((*scene)->lights().size()) : 8;
  task.predicted_s = static_cast<double>(n) * *samples *
                     (direct ? kDirectSampleSeconds : kPathSampleSeconds) * std::max(1.0, lights);
  // Light is told by spectrum: each of them is looked up once, and is a value of each point.
  const double spectra = static_cast<double>((*scene)->spectra().size() + 1);
  task.predicted_s += spectra * static_cast<double>(wavelengths->size()) *
                      (kLookUpSeconds + static_cast<double>(n) * kWavelengthSeconds);
  task.cost = response->mutable_cost();
  task.run = [work, response](const std::stop_token& stop) { return work(stop, response); };
  return task;
}

}  // namespace lucerna::rpc
