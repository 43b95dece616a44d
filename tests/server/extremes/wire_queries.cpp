#include "tests/server/extremes/wire_queries.h"

#include <fmt/format.h>

#include <cmath>

#include "tests/server/extremes/wire_answers.h"

namespace lucerna::testing {
namespace {

bool bit(const std::string& bits, std::size_t i) {
  return (static_cast<unsigned char>(bits[i / 8]) >> (i % 8) & 1) != 0;
}

}  // namespace

WireQueries::WireQueries(Service& service, ExtremeNumbers& numbers, std::string scene_id, int batch)
    : service_(service), n_(numbers), scene_id_(std::move(scene_id)), batch_(batch) {
  v1::ListLightsRequest list;
  list.set_scene_id(scene_id_);
  v1::ListLightsResponse lights;
  const grpc::Status listed =
      testing::ask([&](auto* c) { return service_.scenes.ListLights(c, list, &lights); });
  hold(listed.ok(), "ListLights", 0, listed.error_message());
  numbers_hold("ListLights", lights);
  lights_.assign(lights.lights().begin(), lights.lights().end());

  v1::GetSceneRequest get;
  get.set_scene_id(scene_id_);
  v1::GetSceneResponse scene;
  const grpc::Status got =
      testing::ask([&](auto* c) { return service_.scenes.GetScene(c, get, &scene); });
  hold(got.ok(), "GetScene", 0, got.error_message());
  numbers_hold("GetScene", scene);
  summary_ = scene.summary();

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

void WireQueries::ask_light(const v1::Light& light) {
  sample_le(&light);
  sample_li(&light);
  pdf_li(light);
  pdf_le(light);
  le(&light);
}

void WireQueries::ask_scene() {
  sample_le(nullptr);
  sample_li(nullptr);
  le(nullptr);
  power();
  for (int i = 0; i < 4; ++i) {
    visibility();
    irradiance();
  }
  tile();
}

void WireQueries::sample_li(const v1::Light* light) {
  v1::SampleLiRequest q;
  q.set_scene_id(scene_id_);
  int samples = 1;
  Items items = points(batch_, q.mutable_receivers());
  if (light != nullptr) q.set_light_id(light->id());
  if (n_.chance(0.3)) {
    samples = 1 + static_cast<int>(n_.below(3));
    q.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(samples));
    q.mutable_seed()->set_seed(n_.seed());
    q.mutable_seed()->set_first_item(n_.seed() >> n_.below(64));
  } else {
    sample_values(q.mutable_u(), 2, light != nullptr, items);
  }
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  if (n_.chance(0.4)) normals(q.mutable_normals(), items);
  q.set_test_visibility(n_.chance(0.4));
  if (n_.chance(0.2)) q.set_position_error_m(static_cast<float>(n_.magnitude()));
  area_sampling(q.mutable_accuracy());
  wavelengths(q.mutable_wavelengths_nm());

  Items of_samples;
  for (const Item item : items) of_samples.insert(of_samples.end(), samples, item);
  const std::size_t n = of_samples.size();
  v1::SampleLiResponse r;
  if (!ask("SampleLi", q, &r, &v1::LightingService::Stub::SampleLi)) return;
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("SampleLi", r.value_size(), 3 * n, "value");
  expect("SampleLi", r.wi_size(), 3 * n, "wi");
  expect("SampleLi", r.distance_m_size(), n, "distance_m");
  expect("SampleLi", r.light_offsets_m_size(), 3 * n, "light_offsets_m");
  expect("SampleLi", r.light_normals_size(), 3 * n, "light_normals");
  expect("SampleLi", r.pdf_per_sr_size(), n, "pdf_per_sr");
  expect("SampleLi", r.delta().size(), (n + 7) / 8, "delta");
  expect("SampleLi", r.visible().size(), q.test_visibility() ? (n + 7) / 8 : 0, "visible");
  expect("SampleLi", r.light_ids_size(), light == nullptr ? n : 0, "light_ids");
  expect("SampleLi", r.selection_probability_size(), light == nullptr ? n : 0,
         "selection_probability");
  expect("SampleLi", r.spectral_value_size(), n * spectral, "spectral_value");
  const std::vector<v1::ItemStatus> status = statuses("SampleLi", r.status(), of_samples, true);
  for (std::size_t i = 0; i < n && failures_.empty(); ++i) {
    const int k = static_cast<int>(i);
    if (light == nullptr && !lights_.empty()) {
      const double p = r.selection_probability(k);
      hold(p > 0 && p <= 1, "SampleLi", i, fmt::format("selection_probability = {}", p));
      hold(ids_.contains(r.light_ids(k)), "SampleLi", i, "no light of the scene");
    }
    if (!bit(r.delta(), i))
      hold(r.pdf_per_sr(k) > 0, "SampleLi", i, "without a density and no delta light");
    else
      hold(r.pdf_per_sr(k) == 0, "SampleLi", i, "a delta light with a density");
    if (status[i] != v1::ITEM_STATUS_OK) {
      is_zero("SampleLi", i, r.value(), 3);
      is_zero("SampleLi", i, r.spectral_value(), spectral);
      if (q.test_visibility())
        hold(!bit(r.visible(), i), "SampleLi", i, "visible without an answer");
      continue;
    }
    is_unit("SampleLi", i, r.wi());
  }
  if (failures_.empty() && n_.chance(0.3)) {
    v1::Points found;
    *found.mutable_origin_m() = q.receivers().origin_m();
    *found.mutable_offsets_m() = r.light_offsets_m();
    keep(found);
  }
}

void WireQueries::pdf_li(const v1::Light& light) {
  v1::PdfLiRequest q;
  q.set_scene_id(scene_id_);
  q.set_light_id(light.id());
  Items items = points(batch_, q.mutable_receivers());
  directions(q.mutable_wi(), items, &q.receivers());
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  if (n_.chance(0.4)) normals(q.mutable_normals(), items);
  area_sampling(q.mutable_accuracy());
  v1::PdfLiResponse r;
  if (!ask("PdfLi", q, &r, &v1::LightingService::Stub::PdfLi)) return;
  expect("PdfLi", r.pdf_per_sr_size(), items.size(), "pdf_per_sr");
  const std::vector<v1::ItemStatus> status = statuses("PdfLi", r.status(), items, false);
  for (std::size_t i = 0; i < items.size() && failures_.empty(); ++i)
    if (status[i] != v1::ITEM_STATUS_OK) is_zero("PdfLi", i, r.pdf_per_sr(), 1);
}

void WireQueries::sample_le(const v1::Light* light) {
  v1::SampleLeRequest q;
  q.set_scene_id(scene_id_);
  if (light != nullptr) q.set_light_id(light->id());
  const auto n = static_cast<std::size_t>(batch_);
  q.set_count(static_cast<std::uint32_t>(batch_));
  Items items(n, Item::kGood);
  if (n_.chance(0.3)) {
    q.mutable_seed()->set_seed(n_.seed());
    q.mutable_seed()->set_first_item(n_.seed() >> n_.below(64));
  } else {
    sample_values(q.mutable_u(), 4, light != nullptr, items);
  }
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  wavelengths(q.mutable_wavelengths_nm());
  v1::SampleLeResponse r;
  if (!ask("SampleLe", q, &r, &v1::LightingService::Stub::SampleLe)) return;
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("SampleLe", r.points().offsets_m_size(), 3 * n, "points");
  expect("SampleLe", r.directions_size(), 3 * n, "directions");
  expect("SampleLe", r.light_normals_size(), 3 * n, "light_normals");
  expect("SampleLe", r.value_size(), 3 * n, "value");
  expect("SampleLe", r.pdf_position_per_m2_size(), n, "pdf_position_per_m2");
  expect("SampleLe", r.pdf_direction_per_sr_size(), n, "pdf_direction_per_sr");
  expect("SampleLe", r.light_ids_size(), light == nullptr ? n : 0, "light_ids");
  expect("SampleLe", r.spectral_value_size(), n * spectral, "spectral_value");
  const std::vector<v1::ItemStatus> status = statuses("SampleLe", r.status(), items, true);
  for (std::size_t i = 0; i < n && failures_.empty(); ++i) {
    const int k = static_cast<int>(i);
    if (light == nullptr && !lights_.empty())
      hold(ids_.contains(r.light_ids(k)), "SampleLe", i, "no light of the scene");
    if (status[i] != v1::ITEM_STATUS_OK) {
      is_zero("SampleLe", i, r.value(), 3);
      is_zero("SampleLe", i, r.directions(), 3);
      is_zero("SampleLe", i, r.spectral_value(), spectral);
      continue;
    }
    is_unit("SampleLe", i, r.directions());
    if (triple(r.light_normals(), i) != Vec3<float>{}) is_unit("SampleLe", i, r.light_normals());
    hold(r.pdf_position_per_m2(k) > 0 || r.pdf_direction_per_sr(k) > 0 || light == nullptr ||
             light->delta(),
         "SampleLe", i, "OK, without densities");
  }
  if (failures_.empty()) keep(r.points());
}

void WireQueries::pdf_le(const v1::Light& light) {
  v1::PdfLeRequest q;
  q.set_scene_id(scene_id_);
  q.set_light_id(light.id());
  Items items = points(batch_, q.mutable_points());
  directions(q.mutable_directions(), items);
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  v1::PdfLeResponse r;
  if (!ask("PdfLe", q, &r, &v1::LightingService::Stub::PdfLe)) return;
  expect("PdfLe", r.pdf_position_per_m2_size(), items.size(), "pdf_position_per_m2");
  expect("PdfLe", r.pdf_direction_per_sr_size(), items.size(), "pdf_direction_per_sr");
  const std::vector<v1::ItemStatus> status = statuses("PdfLe", r.status(), items, false);
  for (std::size_t i = 0; i < items.size() && failures_.empty(); ++i) {
    if (status[i] == v1::ITEM_STATUS_OK) continue;
    is_zero("PdfLe", i, r.pdf_position_per_m2(), 1);
    is_zero("PdfLe", i, r.pdf_direction_per_sr(), 1);
  }
}

void WireQueries::le(const v1::Light* light) {
  v1::LeRequest q;
  q.set_scene_id(scene_id_);
  if (light != nullptr) q.set_light_id(light->id());
  Items items = points(batch_, q.mutable_points());
  directions(q.mutable_directions(), items, &q.points());
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  wavelengths(q.mutable_wavelengths_nm());
  v1::LeResponse r;
  if (!ask("Le", q, &r, &v1::LightingService::Stub::Le)) return;
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("Le", r.radiance_cd_m2_size(), 3 * items.size(), "radiance_cd_m2");
  expect("Le", r.light_ids_size(), items.size(), "light_ids");
  expect("Le", r.spectral_radiance_size(), items.size() * spectral, "spectral_radiance");
  const std::vector<v1::ItemStatus> status = statuses("Le", r.status(), items, false);
  for (std::size_t i = 0; i < items.size() && failures_.empty(); ++i) {
    if (status[i] == v1::ITEM_STATUS_OK) continue;
    is_zero("Le", i, r.radiance_cd_m2(), 3);
    is_zero("Le", i, r.spectral_radiance(), spectral);
  }
}

void WireQueries::power() {
  v1::EstimatePowerRequest q;
  q.set_scene_id(scene_id_);
  q.set_method(n_.chance(0.5) ? v1::EstimatePowerRequest::METHOD_EXACT
                              : v1::EstimatePowerRequest::METHOD_APPROXIMATE);
  wavelengths(q.mutable_wavelengths_nm());
  v1::EstimatePowerResponse r;
  if (!ask("EstimatePower", q, &r, &v1::LightingService::Stub::EstimatePower)) return;
  expect("EstimatePower", r.lights_size(), lights_.size(), "lights");
  items_ += lights_.size();
}

void WireQueries::visibility() {
  v1::TestVisibilityRequest q;
  q.set_scene_id(scene_id_);
  Items items;
  if (n_.chance(0.5)) {
    items = points(batch_, q.mutable_segments()->mutable_from());
    const Items ends = points(batch_, q.mutable_segments()->mutable_to());
    for (std::size_t i = 0; i < items.size(); ++i)
      if (ends[i] == Item::kInvalid) items[i] = Item::kInvalid;
  } else {
    items = points(batch_, q.mutable_rays()->mutable_from());
    directions(q.mutable_rays()->mutable_directions(), items, &q.rays().from());
    if (n_.chance(0.5)) {
      for (Item& item : items) {
        const float length = n_.component();
        q.mutable_rays()->add_lengths_m(length);
        if (!(length > 0) || !std::isfinite(length))
          item = Item::kInvalid;
        else if (length < std::numeric_limits<float>::min() && item == Item::kGood)
          item = Item::kEither;
      }
    }
  }
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  if (n_.chance(0.4)) normals(q.mutable_normals(), items);
  if (n_.chance(0.2)) q.set_position_error_m(static_cast<float>(n_.magnitude()));
  v1::TestVisibilityResponse r;
  if (!ask("TestVisibility", q, &r, &v1::LightingService::Stub::TestVisibility)) return;
  expect("TestVisibility", r.count(), items.size(), "count");
  expect("TestVisibility", r.visible().size(), (items.size() + 7) / 8, "visible");
  const std::vector<v1::ItemStatus> status = statuses("TestVisibility", r.status(), items, false);
  for (std::size_t i = 0; i < items.size() && failures_.empty(); ++i)
    if (status[i] != v1::ITEM_STATUS_OK)
      hold(!bit(r.visible(), i), "TestVisibility", i, "visible without an answer");
}

void WireQueries::irradiance() {
  v1::EstimateIrradianceRequest q;
  q.set_scene_id(scene_id_);
  // An item has several samples of several rays each.
  Items items = points(batch_ / 4, q.mutable_receivers());
  normals(q.mutable_normals(), items);
  q.set_bounces(static_cast<std::uint32_t>(n_.below(3)));
  if (q.bounces() == 0) wavelengths(q.mutable_wavelengths_nm());
  q.set_per_light(n_.chance(0.5));
  q.mutable_seed()->set_seed(n_.seed());
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  if (n_.chance(0.2)) q.set_position_error_m(static_cast<float>(n_.magnitude()));
  q.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(1 + n_.below(4)));
  area_sampling(q.mutable_accuracy());
  v1::EstimateIrradianceResponse r;
  if (!ask("EstimateIrradiance", q, &r, &v1::LightingService::Stub::EstimateIrradiance)) return;
  const std::size_t n = items.size();
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("EstimateIrradiance", r.irradiance_lx_size(), 3 * n, "irradiance_lx");
  expect("EstimateIrradiance", r.illuminance_lx_size(), n, "illuminance_lx");
  expect("EstimateIrradiance", r.standard_error_lx_size(), q.accuracy().samples() > 1 ? n : 0,
         "standard_error_lx");
  expect("EstimateIrradiance", r.zero_bound_lx_size(), n, "zero_bound_lx");
  expect("EstimateIrradiance", r.shares_size(), q.per_light() ? lights_.size() : 0, "shares");
  expect("EstimateIrradiance", r.spectral_irradiance_size(), n * spectral, "spectral_irradiance");
  const std::vector<v1::ItemStatus> status =
      statuses("EstimateIrradiance", r.status(), items, false);
  for (std::size_t i = 0; i < n && failures_.empty(); ++i) {
    if (status[i] == v1::ITEM_STATUS_OK) continue;
    is_zero("EstimateIrradiance", i, r.irradiance_lx(), 3);
    is_zero("EstimateIrradiance", i, r.illuminance_lx(), 1);
    is_zero("EstimateIrradiance", i, r.zero_bound_lx(), 1);
    is_zero("EstimateIrradiance", i, r.spectral_irradiance(), spectral);
    for (const v1::LightShare& share : r.shares())
      is_zero("EstimateIrradiance", i, share.illuminance_lx(), 1);
  }
}

void WireQueries::tile() {
  v1::RenderTileRequest q;
  q.set_scene_id(scene_id_);
  q.set_seed(n_.seed());
  q.set_bounces(static_cast<std::uint32_t>(n_.below(3)));
  q.mutable_accuracy()->set_samples(1U << n_.below(2));
  area_sampling(q.mutable_accuracy());
  switch (n_.below(3)) {
    case 0:
      q.set_time_s(n_.scalar());
      break;
    case 1:
      q.mutable_shutter()->set_offset_s(n_.with_sign(n_.magnitude()));
      q.mutable_shutter()->set_length_s(n_.magnitude());
      break;
    default:
      break;
  }
  v1::RenderTileResponse r;
  const grpc::Status s =
      testing::ask([&](auto* c) { return service_.render.RenderTile(c, q, &r); });
  hold(s.ok(), "RenderTile", 0, fmt::format("{} {}", int(s.error_code()), s.error_message()));
  if (!s.ok()) return;
  const std::size_t pixels = std::size_t{summary_.image_width()} * summary_.image_height();
  expect("RenderTile", r.tile().sum().size(), 3 * sizeof(double) * pixels, "sum");
  expect("RenderTile", r.tile().deviation().size(), 3 * sizeof(double) * pixels, "deviation");
  items_ += pixels;
  numbers_hold("RenderTile", r);
}

void WireQueries::ask_refused() {
  const auto is_refused = [&](const std::string& field, const grpc::Status& s) {
    hold(s.error_code() == grpc::StatusCode::INVALID_ARGUMENT &&
             s.error_message().find(field) != std::string::npos,
         "refusal", 0, fmt::format("{}: {} {}", field, int(s.error_code()), s.error_message()));
  };
  if (lights_.empty()) return;
  v1::SampleLiRequest q;
  q.set_scene_id(scene_id_);
  q.mutable_receivers()->mutable_offsets_m()->Resize(3, 1);
  q.mutable_u()->mutable_u()->Resize(2, 0.5F);
  q.set_light_id(lights_[0].id());
  const auto sample = [&] {
    v1::SampleLiResponse r;
    return testing::ask([&](auto* c) { return service_.lighting.SampleLi(c, q, &r); });
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
}

template <typename Request, typename Response>
bool WireQueries::ask(const std::string& name, const Request& request, Response* response,
                      grpc::Status (v1::LightingService::Stub::*call)(grpc::ClientContext*,
                                                                      const Request&, Response*)) {
  const grpc::Status s =
      testing::ask([&](auto* c) { return (service_.lighting.*call)(c, request, response); });
  hold(s.ok(), name, 0, fmt::format("{} {}", int(s.error_code()), s.error_message()));
  if (s.ok()) numbers_hold(name, *response);
  if (!failures_.empty()) failures_.push_back(request.ShortDebugString().substr(0, 200));
  return s.ok();
}

}  // namespace lucerna::testing
