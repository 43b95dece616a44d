// SampleLi and PdfLi.
#include "tests/server/extremes/wire_queries.h"

namespace lucerna::testing {

void WireQueries::sample_li(const v1::Light* light) {
  auto q = about<v1::SampleLiRequest>(scene_id_);
  int samples = 1;
  bool estimated = false;
  Items items = points(batch(), q.mutable_receivers());
  if (light != nullptr) q.set_light_id(light->id());
  if (n_.chance(0.3)) {
    samples = 1 + static_cast<int>(n_.below(3));
    estimated = items.size() <= 64 && n_.chance(0.3);
    if (!estimated) {
      q.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(samples));
    } else if (n_.chance(0.5)) {
      v1::TargetError* target = q.mutable_accuracy()->mutable_target_error();
      target->set_relative(n_.magnitude(0.1, 10));
      target->set_max_samples(256);
    } else {
      q.mutable_accuracy()->set_time_budget_s(1e-9);
    }
    q.mutable_seed()->set_seed(n_.seed());
    q.mutable_seed()->set_first_item(n_.seed() >> n_.below(64));
  } else {
    sample_values(q.mutable_u(), 2, light != nullptr, items);
  }
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  if (n_.chance(0.4)) normals(q.mutable_normals(), items);
  q.set_test_visibility(n_.chance(0.4));
  if (n_.chance(0.2)) q.set_position_error_m(static_cast<float>(n_.magnitude()));
  methods(q.mutable_accuracy());
  wavelengths(q.mutable_wavelengths_nm(), q.test_visibility());

  v1::SampleLiResponse r;
  if (!ask(q, &r)) return;
  expect("SampleLi", r.has_estimates(), estimated, "messages of estimates");
  if (estimated) expect("SampleLi", r.estimates().samples_size(), items.size(), "counts");
  if (!failures_.empty()) return;
  Items of_samples;
  for (std::size_t p = 0; p < items.size(); ++p) {
    const std::uint32_t own = estimated ? r.estimates().samples(static_cast<int>(p)) : samples;
    of_samples.insert(of_samples.end(), own, items[p]);
  }
  const std::size_t n = of_samples.size();
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("SampleLi", r.value_size(), 3 * n, "value");
  expect("SampleLi", r.wi_size(), 3 * n, "wi");
  expect("SampleLi", r.distance_m_size(), n, "distance_m");
  expect("SampleLi", r.light_offsets_m_size(), 3 * n, "light_offsets_m");
  expect("SampleLi", r.light_normals_size(), 3 * n, "light_normals");
  expect("SampleLi", r.pdf_per_sr_size(), n, "pdf_per_sr");
  expect("SampleLi", r.delta().size(), (n + 7) / 8, "delta");
  expect("SampleLi", r.visible().size(), q.test_visibility() ? (n + 7) / 8 : 0, "visible");
  if (!failures_.empty()) return;
  are_shares("SampleLi", r.transmittance(), r.visible(), n,
             q.test_visibility() && in_part(q.accuracy()));
  expect("SampleLi", r.light_ids_size(), light == nullptr ? n : 0, "light_ids");
  expect("SampleLi", r.selection_probability_size(), light == nullptr ? n : 0,
         "selection_probability");
  expect("SampleLi", r.spectral_value_size(), n * spectral, "spectral_value");
  const std::vector<v1::ItemStatus> status = statuses("SampleLi", r.status(), of_samples, true);
  for (std::size_t i = 0; i < n && failures_.empty(); ++i) {
    const int k = static_cast<int>(i);
    if (light == nullptr) {
      is_probability("SampleLi", i, r.selection_probability(k));
      // No light reaches the receiver, or the receiver is not valid.
      const bool none = r.light_ids(k) == 0 && status[i] != v1::ITEM_STATUS_OK;
      if (!none) is_light("SampleLi", i, r.light_ids(k));
      if (none)
        hold(r.selection_probability(k) == 1, "SampleLi", i,
             "a selection probability without a light");
    }
    if (!bit(r.delta(), i))
      hold(r.pdf_per_sr(k) > 0, "SampleLi", i, "no density, although not a delta light");
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
  if (estimated && failures_.empty()) estimates(r.estimates(), items, spectral);
  if (failures_.empty() && n_.chance(0.3)) {
    v1::Points found;
    *found.mutable_origin_m() = q.receivers().origin_m();
    *found.mutable_offsets_m() = r.light_offsets_m();
    keep(found);
  }
}

void WireQueries::estimates(const v1::ReceiverEstimates& r, const Items& items,
                            std::size_t wavelengths) {
  const std::string name = "SampleLi.estimates";
  const std::size_t n = items.size();
  expect(name, r.illuminance_lx_size(), n, "illuminance_lx");
  expect(name, r.standard_error_lx_size(), n, "standard_error_lx");
  expect(name, r.lower_lx_size(), n, "lower_lx");
  expect(name, r.upper_lx_size(), n, "upper_lx");
  expect(name, r.spectral_irradiance_size(), n * wavelengths, "spectral_irradiance");
  expect(name, r.spectral_standard_error_size(), n * wavelengths, "spectral_standard_error");
  const std::vector<v1::ItemStatus> status = statuses(name, r.status(), items, false);
  for (std::size_t i = 0; i < n && failures_.empty(); ++i) {
    const int k = static_cast<int>(i);
    hold(r.samples(k) == 1 || (r.samples(k) >= 16 && r.samples(k) % 16 == 0), name, i,
         "samples that are not 16 equal blocks");
    hold(r.lower_lx(k) <= r.upper_lx(k), name, i, "an interval that ends before it begins");
    if (status[i] == v1::ITEM_STATUS_OK) {
      // Each value is rounded separately, and the luminance of sums differs slightly from the sum
      // of luminances.
      const double rounding = r.illuminance_lx(k) * 2e-7, lux = r.illuminance_lx(k);
      hold(lux <= r.upper_lx(k) + rounding && r.lower_lx(k) <= lux + rounding, name, i,
           "an estimate beside its interval");
      continue;
    }
    for (const auto* numbers :
         {&r.illuminance_lx(), &r.standard_error_lx(), &r.lower_lx(), &r.upper_lx()})
      is_zero(name, i, *numbers, 1);
    is_zero(name, i, r.spectral_irradiance(), wavelengths);
    is_zero(name, i, r.spectral_standard_error(), wavelengths);
  }
}

void WireQueries::pdf_li(const v1::Light& light) {
  auto q = about<v1::PdfLiRequest>(scene_id_);
  q.set_light_id(light.id());
  Items items = points(batch(), q.mutable_receivers());
  directions(q.mutable_wi(), items, &q.receivers());
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  if (n_.chance(0.4)) normals(q.mutable_normals(), items);
  methods(q.mutable_accuracy());
  v1::PdfLiResponse r;
  if (!ask(q, &r)) return;
  expect("PdfLi", r.pdf_per_sr_size(), items.size(), "pdf_per_sr");
  const std::vector<v1::ItemStatus> status = statuses("PdfLi", r.status(), items, false);
  for (std::size_t i = 0; i < items.size() && failures_.empty(); ++i)
    if (status[i] != v1::ITEM_STATUS_OK) is_zero("PdfLi", i, r.pdf_per_sr(), 1);
}

}  // namespace lucerna::testing
