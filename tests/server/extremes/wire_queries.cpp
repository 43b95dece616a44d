// The scene itself, EstimatePower, leases, and refused requests.
#include "tests/server/extremes/wire_queries.h"

#include <fmt/format.h>

#include <cmath>

namespace lucerna::testing {

WireQueries::WireQueries(Service& service, ExtremeNumbers& numbers, const WireScene& scene,
                         int batch)
    : service_(service), n_(numbers), scene_(scene), scene_id_(scene.id), batch_(batch) {
  auto list = about<v1::ListLightsRequest>(scene_id_);
  v1::ListLightsResponse lights;
  ask(list, &lights);
  lights_.assign(lights.lights().begin(), lights.lights().end());
  count("ListLights", lights_.size());

  auto get = about<v1::GetSceneRequest>(scene_id_);
  v1::GetSceneResponse got_scene;
  ask(get, &got_scene);
  summary_ = got_scene.summary();
  count("GetScene", 1);

  places_.push_back(vec(summary_.center_m()));
  for (const v1::Light& light : lights_) {
    ids_.insert(light.id());
    if (light.has_bounds()) {
      keep(vec(light.bounds().lower_m()));
      keep(vec(light.bounds().upper_m()));
      keep(vec(light.bounds().lower_m()) * 0.5 + vec(light.bounds().upper_m()) * 0.5);
    }
    for (const v1::Vector3& corner : light.diffuse_area().corners_m()) keep(vec(corner));
    for (const v1::Vector3& corner : light.image_infinite().portal_m()) keep(vec(corner));
  }
}

void WireQueries::query_light(const v1::Light& light) {
  sample_le(&light);
  sample_li(&light);
  pdf_li(light);
  pdf_le(light);
  le(&light);
}

void WireQueries::query_scene() {
  query_points();
  tile();
  image();
  surfaces();
}

void WireQueries::query_points() {
  sample_le(nullptr);
  sample_li(nullptr);
  le(nullptr);
  power(true);
  power(false);
  for (int i = 0; i < 4; ++i) {
    visibility();
    irradiance();
  }
}

/// The power of all lights, page by page, or of some lights, one of them possibly twice.
void WireQueries::power(bool all) {
  auto q = about<v1::EstimatePowerRequest>(scene_id_);
  if (!all && !lights_.empty())
    for (std::uint64_t n = 1 + n_.below(8); n > 0; --n) q.add_light_ids(n_.one_of(lights_).id());
  std::vector<std::uint64_t> requested(q.light_ids().begin(), q.light_ids().end());
  if (requested.empty())
    for (const v1::Light& light : lights_) requested.push_back(light.id());
  q.set_method(static_cast<v1::EstimatePowerRequest::Method>(
      n_.below(v1::EstimatePowerRequest::Method_MAX + std::uint64_t{1})));
  stop_rule(q.mutable_accuracy());
  q.set_seed(n_.seed());
  if (n_.chance(0.5)) q.set_page_size(static_cast<std::uint32_t>(1 + n_.below(12)));
  wavelengths(q.mutable_wavelengths_nm());
  std::size_t listed = 0;
  do {
    v1::EstimatePowerResponse r;
    if (!ask(q, &r)) return;
    hold(r.has_total(), "EstimatePower", listed, "no total");
    for (const v1::LightPower& power : r.lights()) {
      hold(listed < requested.size() && power.light_id() == requested[listed], "EstimatePower",
           listed, "not the requested light");
      expect("EstimatePower", power.spectral_w_per_nm_size(), q.wavelengths_nm_size(),
             "spectral_w_per_nm");
      ++listed;
    }
    q.set_page_token(r.next_page_token());
  } while (!q.page_token().empty() && failures_.empty());
  expect("EstimatePower", listed, requested.size(), "lights");
  count("EstimatePower", listed);
}

void WireQueries::query_edit() {
  if (lights_.empty()) return;
  auto q = about<v1::EditLightsRequest>(scene_id_);
  v1::LightChange& change = *q.add_edits()->mutable_change();
  change.set_light_id(lights_[n_.below(lights_.size())].id());
  if (n_.chance(0.5)) change.set_scale(double{n_.component()});
  if (n_.chance(0.5)) change.set_scale(n_.magnitude(1e-300, 1e9));
  if (n_.chance(0.3)) change.mutable_tint()->set_g(n_.magnitude(1e-300, 1e9));
  if (n_.chance(0.5)) {
    change.mutable_placement()->mutable_shift_m()->set_x(double{n_.component()});
    change.mutable_placement()->mutable_turn_axis()->set_y(double{n_.component()});
    change.mutable_placement()->set_turn_rad(double{n_.component()});
  }
  v1::EditLightsResponse r;
  const grpc::Status s = send(q, &r);
  count("EditLights", 1);
  if (!s.ok()) {
    hold(s.error_code() == grpc::StatusCode::INVALID_ARGUMENT, "EditLights", 0,
         fmt::format("{} {}", int(s.error_code()), s.error_message()));
    return;
  }
  if (!answered("EditLights", s, q, r) || r.scene_id() == scene_id_) return;
  auto list = about<v1::ListLightsRequest>(r.scene_id());
  v1::ListLightsResponse lights;
  ask(list, &lights);
  auto end = about<v1::ReleaseSceneRequest>(r.scene_id());
  v1::ReleaseSceneResponse ended;
  const grpc::Status e = send(end, &ended);
  hold(e.ok(), "ReleaseScene", 0, e.error_message());
}

void WireQueries::query_lease() {
  auto q = about<v1::RenewLeaseRequest>(scene_id_);
  q.set_lease_s(n_.chance(0.5) ? double{n_.component()}
                               : n_.with_sign(n_.magnitude(1e-300, 1e300)));
  v1::RenewLeaseResponse r;
  const grpc::Status s = send(q, &r);
  count("RenewLease", 1);
  if (!(q.lease_s() > 0) || !std::isfinite(q.lease_s())) {
    hold(s.error_code() == grpc::StatusCode::INVALID_ARGUMENT, "RenewLease", 0,
         fmt::format("lease_s = {}: {} {}", q.lease_s(), int(s.error_code()), s.error_message()));
    return;
  }
  if (!answered("RenewLease", s, q, r)) return;

  v1::ListScenesRequest list;
  v1::ListScenesResponse scenes;
  ask(list, &scenes);
  count("ListScenes", scenes.scenes_size());

  auto end = about<v1::ReleaseSceneRequest>(scene_id_);
  end.set_lease_id(r.lease_id());
  v1::ReleaseSceneResponse ended;
  const grpc::Status e = send(end, &ended);
  // The shortest leases have expired by now.
  hold(e.ok() || e.error_code() == grpc::StatusCode::NOT_FOUND, "ReleaseScene", 0,
       e.error_message());
}

void WireQueries::send_invalid() {
  const auto is_refused = [&](const std::string& field, const grpc::Status& s) {
    hold(s.error_code() == grpc::StatusCode::INVALID_ARGUMENT &&
             s.error_message().find(field) != std::string::npos,
         "refusal", 0, fmt::format("{}: {} {}", field, int(s.error_code()), s.error_message()));
  };
  if (lights_.empty()) return;
  auto q = about<v1::SampleLiRequest>(scene_id_);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3, 1);
  q.mutable_u()->mutable_u()->Resize(2, 0.5F);
  q.set_light_id(lights_[0].id());
  const auto sample = [&] {
    v1::SampleLiResponse r;
    return send(q, &r);
  };
  const double bad = n_.chance(0.5) ? NAN : n_.with_sign(INFINITY);
  q.mutable_receivers()->mutable_origin_m()->set_y(bad);
  is_refused("receivers.origin_m.y", sample());
  q.mutable_receivers()->clear_origin_m();
  q.set_time_s(bad);
  is_refused("time_s", sample());
  q.clear_time_s();
  q.set_position_error_m(n_.chance(0.5) ? -static_cast<float>(n_.magnitude())
                                        : static_cast<float>(bad));
  is_refused("position_error_m", sample());
  q.clear_position_error_m();
  q.mutable_u()->set_u(1, n_.chance(0.5) ? -static_cast<float>(n_.magnitude(1e-30, 1e30))
                                         : 1 + static_cast<float>(n_.magnitude(1e-6, 1e30)));
  is_refused("u.u[1]", sample());
  q.mutable_u()->set_u(1, 0.5F);
  const int ways = v1::ThinGlass_MAX + 1;
  q.mutable_accuracy()->set_thin_glass(
      static_cast<v1::ThinGlass>(n_.chance(0.5) ? ways + static_cast<int>(n_.below(1U << 30))
                                                : -1 - static_cast<int>(n_.below(100))));
  is_refused("accuracy.thin_glass", sample());
  q.clear_accuracy();
  if (!scene_.has_coloured_media) return;
  q.set_test_visibility(true);
  q.add_wavelengths_nm(555);
  is_refused("wavelengths_nm", sample());
}

}  // namespace lucerna::testing
