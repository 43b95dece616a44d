// SampleLe, PdfLe and Le.
#include "tests/server/extremes/wire_queries.h"

namespace lucerna::testing {

void WireQueries::sample_le(const v1::Light* light) {
  auto q = about<v1::SampleLeRequest>(scene_id_);
  if (light != nullptr) q.set_light_id(light->id());
  q.set_count(static_cast<std::uint32_t>(batch()));
  const std::size_t n = q.count();
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
  if (!ask(q, &r)) return;
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("SampleLe", r.points().offsets_m_size(), 3 * n, "points");
  expect("SampleLe", r.directions_size(), 3 * n, "directions");
  expect("SampleLe", r.light_normals_size(), 3 * n, "light_normals");
  expect("SampleLe", r.value_size(), 3 * n, "value");
  expect("SampleLe", r.pdf_position_per_m2_size(), n, "pdf_position_per_m2");
  expect("SampleLe", r.pdf_direction_per_sr_size(), n, "pdf_direction_per_sr");
  expect("SampleLe", r.light_ids_size(), light == nullptr ? n : 0, "light_ids");
  expect("SampleLe", r.selection_probability_size(), light == nullptr ? n : 0,
         "selection_probability");
  expect("SampleLe", r.spectral_value_size(), n * spectral, "spectral_value");
  const std::vector<v1::ItemStatus> status = statuses("SampleLe", r.status(), items, true);
  for (std::size_t i = 0; i < n && failures_.empty(); ++i) {
    const int k = static_cast<int>(i);
    if (light == nullptr) {
      is_probability("SampleLe", i, r.selection_probability(k));
      is_light("SampleLe", i, r.light_ids(k));
    }
    if (status[i] != v1::ITEM_STATUS_OK) {
      is_zero("SampleLe", i, r.value(), 3);
      is_zero("SampleLe", i, r.directions(), 3);
      is_zero("SampleLe", i, r.spectral_value(), spectral);
      continue;
    }
    is_unit("SampleLe", i, r.directions());
    if (triple(r.light_normals(), i) != Vec3f{}) is_unit("SampleLe", i, r.light_normals());
    hold(r.pdf_position_per_m2(k) > 0 || r.pdf_direction_per_sr(k) > 0 || light == nullptr ||
             light->delta(),
         "SampleLe", i, "OK, without densities");
  }
  if (failures_.empty()) keep(r.points());
}

void WireQueries::pdf_le(const v1::Light& light) {
  auto q = about<v1::PdfLeRequest>(scene_id_);
  q.set_light_id(light.id());
  Items items = points(batch(), q.mutable_points());
  directions(q.mutable_directions(), items);
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  v1::PdfLeResponse r;
  if (!ask(q, &r)) return;
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
  auto q = about<v1::LeRequest>(scene_id_);
  if (light != nullptr) q.set_light_id(light->id());
  Items items = points(batch(), q.mutable_points());
  directions(q.mutable_directions(), items, &q.points());
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  wavelengths(q.mutable_wavelengths_nm(), true);
  v1::LeResponse r;
  if (!ask(q, &r)) return;
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("Le", r.radiance_cd_m2_size(), 3 * items.size(), "radiance_cd_m2");
  expect("Le", r.light_ids_size(), items.size(), "light_ids");
  expect("Le", r.spectral_radiance_size(), items.size() * spectral, "spectral_radiance");
  const std::vector<v1::ItemStatus> status = statuses("Le", r.status(), items, false);
  for (std::size_t i = 0; i < items.size() && failures_.empty(); ++i) {
    const std::uint64_t met = r.light_ids(static_cast<int>(i));
    if (met != 0) is_light("Le", i, met);
    hold(met == 0 || light == nullptr || met == light->id(), "Le", i,
         "another light than the requested one");
    if (status[i] == v1::ITEM_STATUS_OK) continue;
    hold(met == 0, "Le", i, "a light for an item without an answer");
    is_zero("Le", i, r.radiance_cd_m2(), 3);
    is_zero("Le", i, r.spectral_radiance(), spectral);
  }
}

}  // namespace lucerna::testing
