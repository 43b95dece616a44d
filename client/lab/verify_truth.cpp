#include "client/lab/verify_truth.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "client/library/batch_parts.h"
#include "client/library/batches.h"
#include "client/library/pages.h"
#include "client/terminal/luminance.h"

namespace lucerna::verify {
namespace {

// Hypotheses need their predictions only this precisely.
constexpr double kPredictionError = 3e-3;

// A relative error that no estimate reaches.
constexpr double kNever = 1e-9;

/// Adds what the standard error of an estimate does not know: obstacles that hide the light of less
/// than about one sample.
Estimates with_missed(std::vector<double> values, std::vector<double> errors, std::uint32_t samples,
                      bool exact) {
  for (std::size_t i = 0; i < errors.size() && !exact; ++i)
    errors[i] = std::hypot(errors[i], values[i] / samples);
  return {std::move(values), std::move(errors)};
}

bool is_ok(const google::protobuf::RepeatedField<int>& statuses, std::size_t i) {
  return statuses.empty() || statuses[static_cast<int>(i)] == v1::ITEM_STATUS_OK;
}

Double3 triple(const google::protobuf::RepeatedField<float>& all, std::size_t i) {
  const int at = static_cast<int>(3 * i);
  return {all[at], all[at + 1], all[at + 2]};
}

std::vector<double> doubles(const google::protobuf::RepeatedField<float>& all) {
  return {all.begin(), all.end()};
}

}  // namespace

double luminance(const Double3& rgb) {
  const float all[] = {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]),
                       static_cast<float>(rgb[2])};
  return cli::luminance(all);
}

Truth::Truth(cli::Session& session, std::string scene_id)
    : session_(session), scene_id_(std::move(scene_id)) {
  const v1::ListLightsResponse all = list_lights(session_, scene_id_);
  lights_.assign(all.lights().begin(), all.lights().end());
  v1::GetSceneRequest request;
  request.set_scene_id(scene_id_);
  scene_ = session_.value_or_fail(session_.client().get_scene(request, session_.call_options()))
               .summary();
}

const v1::Light& Truth::light(std::uint64_t id) const {
  return *std::ranges::find(lights_, id, &v1::Light::id);
}

client::BatchOptions Truth::batches() { return {.max_items = 0, .call = session_.call_options()}; }

std::string Truth::id_for(const Variation& variation) const {
  return variation.scene_id.empty() ? scene_id_ : variation.scene_id;
}

std::vector<double> Truth::densities(std::uint64_t light, const std::vector<Double3>& points,
                                     const std::vector<Double3>& normals,
                                     const std::vector<Double3>& directions, v1::AreaSampling way,
                                     const Variation& variation) {
  v1::PdfLiRequest request;
  request.set_scene_id(id_for(variation));
  request.set_light_id(light);
  *request.mutable_receivers() = client::make_points(variation.points(points));
  client::fill(variation.vectors(directions), request.mutable_wi());
  client::fill(variation.vectors(normals), request.mutable_normals());
  request.mutable_accuracy()->set_area_sampling(way);
  return doubles(
      session_.value_or_fail(client::pdf_li_in_batches(session_.client(), request, batches()))
          .pdf_per_sr());
}

LightSamples Truth::samples(std::uint64_t light, const std::vector<Double3>& points,
                            const std::vector<Double3>& normals, std::uint32_t count,
                            std::uint64_t seed, v1::AreaSampling way, const Variation& variation) {
  v1::SampleLiRequest request;
  request.set_scene_id(id_for(variation));
  request.set_light_id(light);
  *request.mutable_receivers() = client::make_points(variation.points(points));
  client::fill(variation.vectors(normals), request.mutable_normals());
  request.mutable_seed()->set_seed(seed);
  request.mutable_accuracy()->set_samples(count);
  request.mutable_accuracy()->set_area_sampling(way);
  const v1::SampleLiResponse response =
      session_.value_or_fail(client::sample_li_in_batches(session_.client(), request, batches()));
  LightSamples s;
  const std::size_t n = points.size() * count;
  for (std::size_t i = 0; i < n; ++i) {
    s.value.push_back(triple(response.value(), i));
    s.directions.push_back(variation.back(triple(response.wi(), i)));
    s.light_normals.push_back(variation.back(triple(response.light_normals(), i)));
    s.distance.push_back(variation.scale * response.distance_m(static_cast<int>(i)));
    s.pdf.push_back(response.pdf_per_sr(static_cast<int>(i)));
    s.ok.push_back(is_ok(response.status(), i));
    s.behind.push_back(!response.status().empty() &&
                       response.status(static_cast<int>(i)) == v1::ITEM_STATUS_BEHIND);
  }
  return s;
}

std::vector<Double3> Truth::radiances(std::uint64_t light, const std::vector<Double3>& points,
                                      const std::vector<Double3>& directions) {
  v1::LeRequest request;
  request.set_scene_id(scene_id_);
  request.set_light_id(light);
  *request.mutable_points() = client::make_points(points);
  client::fill(directions, request.mutable_directions());
  const v1::LeResponse response =
      session_.value_or_fail(client::le_in_batches(session_.client(), request, batches()));
  std::vector<Double3> result;
  for (std::size_t i = 0; i < points.size(); ++i)
    result.push_back(triple(response.radiance_cd_m2(), i));
  return result;
}

std::vector<std::uint64_t> Truth::lights_met(const std::vector<Double3>& points,
                                             const std::vector<Double3>& directions,
                                             const std::vector<double>& distances) {
  const Double3 center = double3(scene_.center_m());
  std::vector<Double3> starts = points;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (std::isfinite(distances[i])) {
      starts[i] = points[i] + kAlmostThere * distances[i] * directions[i];
    } else if (std::isinf(distances[i])) {
      starts[i] = center + (2 * scene_.radius_m() + 1) * directions[i];
    }
  }
  std::vector<std::uint64_t> met = lights_ahead(starts, directions);
  // A ray may pass a point light and meet another one behind it.
  std::vector<std::size_t> local;
  std::vector<Double3> before, after;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (!std::isfinite(distances[i])) continue;
    local.push_back(i);
    before.push_back(starts[i]);
    after.push_back(points[i] + (2 - kAlmostThere) * distances[i] * directions[i]);
  }
  const std::vector<bool> empty = visible(before, after);
  for (std::size_t k = 0; k < local.size(); ++k)
    if (empty[k]) met[local[k]] = 0;
  const auto is_far = [](const v1::Light& l) { return !l.delta() && !l.has_bounds(); };
  if (std::ranges::count_if(lights_, is_far) > 1) {
    for (std::uint64_t& id : met)
      if (id != 0 && is_far(light(id))) id = 0;
  }
  return met;
}

std::vector<std::uint64_t> Truth::lights_ahead(const std::vector<Double3>& points,
                                               const std::vector<Double3>& directions) {
  v1::LeRequest request;
  request.set_scene_id(scene_id_);
  *request.mutable_points() = client::make_points(points);
  client::fill(directions, request.mutable_directions());
  const v1::LeResponse response =
      session_.value_or_fail(client::le_in_batches(session_.client(), request, batches()));
  return {response.light_ids().begin(), response.light_ids().end()};
}

void Truth::emission_densities(std::uint64_t light, const std::vector<Double3>& points,
                               const std::vector<Double3>& directions,
                               std::vector<double>* position, std::vector<double>* direction) {
  v1::PdfLeRequest request;
  request.set_scene_id(scene_id_);
  request.set_light_id(light);
  *request.mutable_points() = client::make_points(points);
  client::fill(directions, request.mutable_directions());
  const v1::PdfLeResponse response =
      session_.value_or_fail(client::pdf_le_in_batches(session_.client(), request, batches()));
  *position = doubles(response.pdf_position_per_m2());
  *direction = doubles(response.pdf_direction_per_sr());
}

Estimates Truth::powers(const std::vector<std::uint64_t>& lights, const std::string& scene_id) {
  // A light may be named by several rows.
  std::map<std::uint64_t, std::pair<double, double>> by_id;
  v1::EstimatePowerRequest request;
  request.set_scene_id(scene_id.empty() ? scene_id_ : scene_id);
  for (const std::uint64_t id : lights)
    if (by_id.emplace(id, std::pair(0.0, 0.0)).second) request.add_light_ids(id);
  const auto powers = session_.value_or_fail(client::all_pages(request, [&](const auto& page) {
    return session_.client().estimate_power(page, session_.call_options());
  }));
  for (const v1::LightPower& p : powers.lights())
    by_id[p.light_id()] = {p.power_lm(), p.error_lm()};
  Estimates result;
  for (const std::uint64_t id : lights) {
    result.value.push_back(by_id[id].first);
    result.standard_error.push_back(by_id[id].second);
  }
  return result;
}

std::vector<double> Truth::unoccluded(std::uint64_t light, const std::vector<Double3>& points,
                                      const std::vector<Double3>& normals,
                                      const Variation& variation) {
  v1::SampleLiRequest request;
  request.set_scene_id(id_for(variation));
  request.set_light_id(light);
  *request.mutable_receivers() = client::make_points(variation.points(points));
  client::fill(variation.vectors(normals), request.mutable_normals());
  request.mutable_seed()->set_seed(1);
  v1::TargetError* target = request.mutable_accuracy()->mutable_target_error();
  target->set_relative(kPredictionError);
  target->set_max_samples(8192);
  const v1::SampleLiResponse response =
      session_.value_or_fail(client::sample_li_in_batches(session_.client(), request, batches()));
  return doubles(response.estimates().illuminance_lx());
}

std::vector<double> Truth::without_cosine(std::uint64_t light, const std::vector<Double3>& points,
                                          const std::vector<Double3>& normals,
                                          std::uint32_t samples, std::uint64_t seed) {
  v1::SampleLiRequest request;
  request.set_scene_id(scene_id_);
  request.set_light_id(light);
  *request.mutable_receivers() = client::make_points(points);
  client::fill(normals, request.mutable_normals());
  request.mutable_seed()->set_seed(seed);
  request.set_test_visibility(true);
  request.mutable_accuracy()->set_samples(samples);
  request.mutable_accuracy()->set_area_sampling(v1::AREA_SAMPLING_SOLID_ANGLE);
  const v1::SampleLiResponse response =
      session_.value_or_fail(client::sample_li_in_batches(session_.client(), request, batches()));
  std::vector<double> result;
  for (std::size_t at = 0; at < points.size(); ++at) {
    double sum = 0;
    for (std::size_t i = at * samples; i < (at + 1) * samples; ++i) {
      const double pdf = response.pdf_per_sr(static_cast<int>(i));
      if (!is_ok(response.status(), i) || !(pdf > 0) || !client::bit(response.visible(), i))
        continue;
      if (dot(normals[at], triple(response.wi(), i)) > 0)
        sum += luminance(triple(response.value(), i)) / pdf;
    }
    result.push_back(sum / samples);
  }
  return result;
}

Estimates Truth::illuminances(std::uint64_t light, const std::vector<Double3>& points,
                              const std::vector<Double3>& normals, std::uint32_t samples,
                              std::uint64_t seed) {
  v1::SampleLiRequest request;
  request.set_scene_id(scene_id_);
  request.set_light_id(light);
  *request.mutable_receivers() = client::make_points(points);
  client::fill(normals, request.mutable_normals());
  request.mutable_seed()->set_seed(seed);
  request.set_test_visibility(true);
  // All samples are taken, however small the scatter is: few samples miss small obstacles.
  v1::TargetError* target = request.mutable_accuracy()->mutable_target_error();
  target->set_relative(kNever);
  target->set_max_samples(samples);
  const v1::SampleLiResponse response =
      session_.value_or_fail(client::sample_li_in_batches(session_.client(), request, batches()));
  return with_missed(doubles(response.estimates().illuminance_lx()),
                     doubles(response.estimates().standard_error_lx()), samples,
                     this->light(light).delta());
}

Estimates Truth::illuminances_of_all(const std::vector<Double3>& points,
                                     const std::vector<Double3>& normals, std::uint32_t bounces,
                                     std::uint32_t samples, std::uint64_t seed) {
  v1::EstimateIrradianceRequest request;
  request.set_scene_id(scene_id_);
  *request.mutable_receivers() = client::make_points(points);
  client::fill(normals, request.mutable_normals());
  request.set_bounces(bounces);
  request.mutable_seed()->set_seed(seed);
  request.mutable_accuracy()->set_samples(samples);
  const v1::EstimateIrradianceResponse response = session_.value_or_fail(
      client::estimate_irradiance_in_batches(session_.client(), request, batches()));
  return with_missed(doubles(response.illuminance_lx()), doubles(response.standard_error_lx()),
                     samples, false);
}

std::vector<bool> Truth::visible(const std::vector<Double3>& from, const std::vector<Double3>& to) {
  v1::TestVisibilityRequest request;
  request.set_scene_id(scene_id_);
  *request.mutable_segments()->mutable_from() = client::make_points(from);
  *request.mutable_segments()->mutable_to() = client::make_points(to);
  const v1::TestVisibilityResponse response = session_.value_or_fail(
      client::test_visibility_in_batches(session_.client(), request, batches()));
  std::vector<bool> result(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) result[i] = client::bit(response.visible(), i);
  return result;
}

std::string Truth::with_light(const v1::Light& light) {
  v1::EditLightsRequest request;
  request.set_scene_id(scene_id_);
  *request.add_edits()->mutable_put() = light;
  const auto response = session_.client().edit_lights(request, session_.call_options());
  // A scene that cannot have this light says nothing about the mistake.
  return response.ok() ? response->scene_id() : std::string();
}

}  // namespace lucerna::verify
