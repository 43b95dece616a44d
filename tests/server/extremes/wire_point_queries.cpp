// TestVisibility and EstimateIrradiance.
#include <cmath>

#include "tests/server/extremes/wire_queries.h"

namespace lucerna::testing {

void WireQueries::visibility() {
  auto q = about<v1::TestVisibilityRequest>(scene_id_);
  Items items;
  if (n_.chance(0.5)) {
    const int n = batch();
    items = points(n, q.mutable_segments()->mutable_from());
    const Items ends = points(n, q.mutable_segments()->mutable_to());
    for (std::size_t i = 0; i < items.size(); ++i)
      if (ends[i] == Item::kInvalid) items[i] = Item::kInvalid;
  } else {
    items = points(batch(), q.mutable_rays()->mutable_from());
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
  if (n_.chance(0.5)) q.mutable_accuracy()->set_thin_glass(v1::THIN_GLASS_BLOCKS);
  v1::TestVisibilityResponse r;
  if (!ask(q, &r)) return;
  expect("TestVisibility", r.count(), items.size(), "count");
  expect("TestVisibility", r.visible().size(), (items.size() + 7) / 8, "visible");
  if (!failures_.empty()) return;
  are_shares("TestVisibility", r.transmittance(), r.visible(), items.size(), in_part(q.accuracy()));
  const bool blocked = !scene_.has_panes || q.accuracy().thin_glass() == v1::THIN_GLASS_BLOCKS;
  hold(!blocked || r.cost().through_thin_glass() == 0, "TestVisibility", 0,
       "rays passed panes that block");
  const std::vector<v1::ItemStatus> status = statuses("TestVisibility", r.status(), items, false);
  for (std::size_t i = 0; i < items.size() && failures_.empty(); ++i)
    if (status[i] != v1::ITEM_STATUS_OK)
      hold(!bit(r.visible(), i), "TestVisibility", i, "visible without an answer");
}

void WireQueries::stop_rule(v1::Accuracy* out) {
  if (n_.chance(0.8)) {
    out->set_samples(static_cast<std::uint32_t>(1 + n_.below(4)));
  } else {
    target_or_time(out);
  }
}

void WireQueries::target_or_time(v1::Accuracy* out) {
  if (n_.chance(0.7)) {
    v1::TargetError* target = out->mutable_target_error();
    target->set_relative(n_.magnitude());
    if (n_.chance(0.5)) target->set_absolute_floor(n_.magnitude());
    if (n_.chance(0.5)) target->set_confidence(n_.uniform() * 0.999 + 0.0005);
    target->set_max_samples(64U << n_.below(4));
  } else {
    out->set_time_budget_s(1e-6 * (1 + n_.below(1000)));
  }
}

void WireQueries::irradiance() {
  auto q = about<v1::EstimateIrradianceRequest>(scene_id_);
  // An item has several samples of several rays each: 256 by default.
  const bool by_default = n_.chance(1.0 / 16);
  Items items =
      points(by_default ? 1 + static_cast<int>(n_.below(3)) : batch() / 4, q.mutable_receivers());
  normals(q.mutable_normals(), items);
  bounces(&q);
  if (q.has_bounces() && q.bounces() == 0) wavelengths(q.mutable_wavelengths_nm(), true);
  q.set_per_light(n_.chance(0.5));
  q.mutable_seed()->set_seed(n_.seed());
  if (n_.chance(0.5)) q.mutable_seed()->set_first_item(n_.seed() >> n_.below(64));
  if (n_.chance(0.5)) q.set_time_s(n_.scalar());
  if (n_.chance(0.2)) q.set_position_error_m(static_cast<float>(n_.magnitude()));
  if (!by_default) stop_rule(q.mutable_accuracy());
  methods(q.mutable_accuracy());
  v1::EstimateIrradianceResponse r;
  if (!ask(q, &r)) return;
  const std::size_t n = items.size();
  const auto spectral = static_cast<std::size_t>(q.wavelengths_nm_size());
  expect("EstimateIrradiance", r.irradiance_lx_size(), 3 * n, "irradiance_lx");
  expect("EstimateIrradiance", r.illuminance_lx_size(), n, "illuminance_lx");
  expect("EstimateIrradiance", r.standard_error_lx_size(), q.accuracy().samples() == 1 ? 0 : n,
         "standard_error_lx");
  for (const int size : {r.lower_lx_size(), r.upper_lx_size()})
    expect("EstimateIrradiance", size, r.standard_error_lx_size(), "bounds");
  for (const int size :
       {r.item_costs().samples_size(), r.item_costs().rays_size(), r.item_costs().time_s_size()})
    expect("EstimateIrradiance", size, q.accuracy().has_target_error() ? n : 0, "item_costs");
  expect("EstimateIrradiance", r.spectral_standard_error_size(),
         r.standard_error_lx().empty() ? 0 : n * spectral, "spectral_standard_error");
  for (int i = 0; i < r.lower_lx_size(); ++i)
    hold(r.lower_lx(i) <= r.illuminance_lx(i) && r.illuminance_lx(i) <= r.upper_lx(i),
         "EstimateIrradiance", i, "the estimate is not within its bounds");
  expect("EstimateIrradiance", r.zero_bound_lx_size(), n, "zero_bound_lx");
  expect("EstimateIrradiance", r.shares_size(), q.per_light() ? lights_.size() : 0, "shares");
  expect("EstimateIrradiance", r.spectral_irradiance_size(), n * spectral, "spectral_irradiance");
  const std::vector<v1::ItemStatus> status =
      statuses("EstimateIrradiance", r.status(), items, false);
  for (std::size_t i = 0; i < n && failures_.empty(); ++i) {
    if (status[i] == v1::ITEM_STATUS_OK || status[i] == v1::ITEM_STATUS_MAY_MISS_LIGHT) continue;
    is_zero("EstimateIrradiance", i, r.irradiance_lx(), 3);
    is_zero("EstimateIrradiance", i, r.illuminance_lx(), 1);
    // Inside of a solid no sample found light, which has a bound like any such estimate.
    if (status[i] != v1::ITEM_STATUS_INSIDE_SOLID)
      is_zero("EstimateIrradiance", i, r.zero_bound_lx(), 1);
    is_zero("EstimateIrradiance", i, r.spectral_irradiance(), spectral);
    for (const v1::LightShare& share : r.shares())
      is_zero("EstimateIrradiance", i, share.illuminance_lx(), 1);
  }
}

}  // namespace lucerna::testing
