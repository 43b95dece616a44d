#include "client/library/batch_parts.h"

#include <algorithm>

namespace lucerna::client {
namespace {

using google::protobuf::RepeatedField;

/// Whether an array holds `per_item` entries for each of `items`.
bool fits(int size, std::size_t items, std::size_t per_item) {
  return static_cast<std::size_t>(size) == items * per_item;
}

bool fits_or_empty(int size, std::size_t items, std::size_t per_item) {
  return size == 0 || fits(size, items, per_item);
}

/// Items of a batch of points; 0 if there are not three coordinates for each point.
std::size_t points(const v1::Points& points) {
  return points.offsets_m_size() % 3 == 0 ? points.offsets_m_size() / 3 : 0;
}

std::size_t samples_per_item(const v1::SampleLiRequest& request) {
  return std::max<std::size_t>(1, request.accuracy().samples());
}

/// Keeps the entries of items [first, first + count) of an array that is empty or has all items.
template <class T>
void keep(std::size_t first, std::size_t count, std::size_t per_item, const RepeatedField<T>& from,
          RepeatedField<T>* to) {
  if (from.empty()) return;
  const auto begin = from.begin() + first * per_item;
  to->Add(begin, begin + count * per_item);
}

void keep(std::size_t first, std::size_t count, const v1::Points& from, v1::Points* to) {
  if (from.has_origin_m()) *to->mutable_origin_m() = from.origin_m();
  keep(first, count, 3, from.offsets_m(), to->mutable_offsets_m());
}

v1::Seed advanced(v1::Seed seed, std::size_t items) {
  seed.set_first_item(seed.first_item() + items);
  return seed;
}

template <class T>
void append_all(const RepeatedField<T>& next, RepeatedField<T>* whole) {
  whole->Add(next.begin(), next.end());
}

/// Appends the statuses of a part.  An empty array means that all are OK, in a part and in the
/// whole.
void append_status(const RepeatedField<int>& next, std::size_t count, std::size_t whole_count,
                   RepeatedField<int>* whole) {
  if (next.empty() && whole->empty()) return;
  whole->Resize(static_cast<int>(whole_count), v1::ITEM_STATUS_OK);
  append_all(next, whole);
  whole->Resize(static_cast<int>(whole_count + count), v1::ITEM_STATUS_OK);
}

}  // namespace

void append_cost(const v1::Cost& next, v1::Cost* whole) {
  whole->set_samples(whole->samples() + next.samples());
  whole->set_camera_rays(whole->camera_rays() + next.camera_rays());
  whole->set_indirect_rays(whole->indirect_rays() + next.indirect_rays());
  whole->set_shadow_rays(whole->shadow_rays() + next.shadow_rays());
  whole->set_shadow_map_lookups(whole->shadow_map_lookups() + next.shadow_map_lookups());
  whole->set_shadow_map_compared(whole->shadow_map_compared() + next.shadow_map_compared());
  whole->set_shadow_map_disagreed(whole->shadow_map_disagreed() + next.shadow_map_disagreed());
  whole->set_through_thin_glass(whole->through_thin_glass() + next.through_thin_glass());
  whole->set_cpu_time_s(whole->cpu_time_s() + next.cpu_time_s());
  whole->set_wall_time_s(whole->wall_time_s() + next.wall_time_s());
  whole->set_queue_time_s(whole->queue_time_s() + next.queue_time_s());
}

std::size_t item_count(const v1::SampleLiRequest& request) {
  const std::size_t items = points(request.receivers());
  const std::size_t samples = items * samples_per_item(request);
  const bool fit = fits_or_empty(request.normals_size(), items, 3) &&
                   (!request.has_u() || (fits(request.u().u_size(), samples, 2) &&
                                         fits_or_empty(request.u().u_light_size(), samples, 1)));
  return fit ? items : 0;
}

std::size_t item_count(const v1::PdfLiRequest& request) {
  const std::size_t items = points(request.receivers());
  const bool fit =
      fits(request.wi_size(), items, 3) && fits_or_empty(request.normals_size(), items, 3);
  return fit ? items : 0;
}

std::size_t item_count(const v1::SampleLeRequest& request) {
  const std::size_t rays = request.count();
  const bool fit = !request.has_u() || (fits(request.u().u_size(), rays, 4) &&
                                        fits_or_empty(request.u().u_light_size(), rays, 1));
  return fit ? rays : 0;
}

std::size_t item_count(const v1::PdfLeRequest& request) {
  const std::size_t items = points(request.points());
  return fits(request.directions_size(), items, 3) ? items : 0;
}

std::size_t item_count(const v1::LeRequest& request) {
  const std::size_t items = points(request.points());
  return fits(request.directions_size(), items, 3) ? items : 0;
}

std::size_t item_count(const v1::TestVisibilityRequest& request) {
  const std::size_t items =
      points(request.has_rays() ? request.rays().from() : request.segments().from());
  bool fit = fits_or_empty(request.normals_size(), items, 3);
  if (request.has_rays()) {
    fit = fit && fits(request.rays().directions_size(), items, 3) &&
          fits_or_empty(request.rays().lengths_m_size(), items, 1);
  } else {
    fit = fit && fits(request.segments().to().offsets_m_size(), items, 3);
  }
  return fit ? items : 0;
}

std::size_t item_count(const v1::EstimateIrradianceRequest& request) {
  const std::size_t items = points(request.receivers());
  return fits(request.normals_size(), items, 3) ? items : 0;
}

namespace {

/// Copies the fields that hold for all items.  It copies field by field: a copy of the whole
/// request would copy all arrays for each part.
template <class Request>
Request without_items(const Request& request) {
  Request result;
  result.set_scene_id(request.scene_id());
  if constexpr (requires { request.has_light_id(); }) {
    if (request.has_light_id()) result.set_light_id(request.light_id());
  } else if constexpr (requires { request.light_id(); }) {
    result.set_light_id(request.light_id());
  }
  if constexpr (requires { request.light_name(); }) result.set_light_name(request.light_name());
  if (request.has_time_s()) result.set_time_s(request.time_s());
  if constexpr (requires { request.position_error_m(); }) {
    if (request.has_position_error_m()) result.set_position_error_m(request.position_error_m());
  }
  if (request.has_accuracy()) *result.mutable_accuracy() = request.accuracy();
  if constexpr (requires { request.wavelengths_nm(); }) {
    *result.mutable_wavelengths_nm() = request.wavelengths_nm();
  }
  return result;
}

/// Copies the sample values of items [first, first + count): `per_item` numbers of `u` and `lights`
/// of `u_light` for each.
template <class Request>
void keep_randomness(std::size_t first, std::size_t count, std::size_t per_item, std::size_t lights,
                     const Request& from, Request* to) {
  if (from.has_u()) {
    keep(first, count, per_item, from.u().u(), to->mutable_u()->mutable_u());
    keep(first, count, lights, from.u().u_light(), to->mutable_u()->mutable_u_light());
  } else if (from.has_seed()) {
    *to->mutable_seed() = advanced(from.seed(), first);
  }
}

}  // namespace

v1::SampleLiRequest part(const v1::SampleLiRequest& request, std::size_t first, std::size_t count) {
  v1::SampleLiRequest result = without_items(request);
  keep(first, count, request.receivers(), result.mutable_receivers());
  keep(first, count, 3, request.normals(), result.mutable_normals());
  const std::size_t samples = samples_per_item(request);
  keep_randomness(first, count, 2 * samples, samples, request, &result);
  result.set_test_visibility(request.test_visibility());
  return result;
}

v1::PdfLiRequest part(const v1::PdfLiRequest& request, std::size_t first, std::size_t count) {
  v1::PdfLiRequest result = without_items(request);
  keep(first, count, request.receivers(), result.mutable_receivers());
  keep(first, count, 3, request.wi(), result.mutable_wi());
  keep(first, count, 3, request.normals(), result.mutable_normals());
  return result;
}

v1::SampleLeRequest part(const v1::SampleLeRequest& request, std::size_t first, std::size_t count) {
  v1::SampleLeRequest result = without_items(request);
  result.set_count(static_cast<std::uint32_t>(count));
  keep_randomness(first, count, 4, 1, request, &result);
  return result;
}

v1::PdfLeRequest part(const v1::PdfLeRequest& request, std::size_t first, std::size_t count) {
  v1::PdfLeRequest result = without_items(request);
  keep(first, count, request.points(), result.mutable_points());
  keep(first, count, 3, request.directions(), result.mutable_directions());
  return result;
}

v1::LeRequest part(const v1::LeRequest& request, std::size_t first, std::size_t count) {
  v1::LeRequest result = without_items(request);
  keep(first, count, request.points(), result.mutable_points());
  keep(first, count, 3, request.directions(), result.mutable_directions());
  return result;
}

v1::TestVisibilityRequest part(const v1::TestVisibilityRequest& request, std::size_t first,
                               std::size_t count) {
  v1::TestVisibilityRequest result = without_items(request);
  if (request.has_rays()) {
    const v1::Rays& rays = request.rays();
    keep(first, count, rays.from(), result.mutable_rays()->mutable_from());
    keep(first, count, 3, rays.directions(), result.mutable_rays()->mutable_directions());
    keep(first, count, 1, rays.lengths_m(), result.mutable_rays()->mutable_lengths_m());
  } else {
    const v1::Segments& segments = request.segments();
    keep(first, count, segments.from(), result.mutable_segments()->mutable_from());
    keep(first, count, segments.to(), result.mutable_segments()->mutable_to());
  }
  keep(first, count, 3, request.normals(), result.mutable_normals());
  return result;
}

v1::EstimateIrradianceRequest part(const v1::EstimateIrradianceRequest& request, std::size_t first,
                                   std::size_t count) {
  v1::EstimateIrradianceRequest result = without_items(request);
  keep(first, count, request.receivers(), result.mutable_receivers());
  keep(first, count, 3, request.normals(), result.mutable_normals());
  if (request.has_bounces()) result.set_bounces(request.bounces());
  result.set_per_light(request.per_light());
  *result.mutable_seed() = advanced(request.seed(), first);
  return result;
}

namespace {

void append_estimates(const v1::ReceiverEstimates& next, v1::ReceiverEstimates* whole) {
  append_status(next.status(), next.samples_size(), whole->samples_size(), whole->mutable_status());
  append_all(next.samples(), whole->mutable_samples());
  append_all(next.illuminance_lx(), whole->mutable_illuminance_lx());
  append_all(next.standard_error_lx(), whole->mutable_standard_error_lx());
  append_all(next.lower_lx(), whole->mutable_lower_lx());
  append_all(next.upper_lx(), whole->mutable_upper_lx());
  append_all(next.spectral_irradiance(), whole->mutable_spectral_irradiance());
  append_all(next.spectral_standard_error(), whole->mutable_spectral_standard_error());
}

}  // namespace

void append(const v1::SampleLiResponse& next, v1::SampleLiResponse* whole) {
  const std::size_t before = whole->pdf_per_sr_size();
  const std::size_t count = next.pdf_per_sr_size();
  append_all(next.value(), whole->mutable_value());
  append_all(next.wi(), whole->mutable_wi());
  append_all(next.distance_m(), whole->mutable_distance_m());
  append_all(next.light_offsets_m(), whole->mutable_light_offsets_m());
  append_all(next.light_normals(), whole->mutable_light_normals());
  append_all(next.pdf_per_sr(), whole->mutable_pdf_per_sr());
  if (!next.delta().empty()) append_bits(next.delta(), count, before, whole->mutable_delta());
  if (!next.visible().empty()) append_bits(next.visible(), count, before, whole->mutable_visible());
  append_all(next.light_ids(), whole->mutable_light_ids());
  append_all(next.selection_probability(), whole->mutable_selection_probability());
  append_status(next.status(), count, before, whole->mutable_status());
  append_all(next.spectral_value(), whole->mutable_spectral_value());
  append_all(next.transmittance(), whole->mutable_transmittance());
  if (next.has_estimates()) append_estimates(next.estimates(), whole->mutable_estimates());
  append_cost(next.cost(), whole->mutable_cost());
}

void append(const v1::PdfLiResponse& next, v1::PdfLiResponse* whole) {
  append_status(next.status(), next.pdf_per_sr_size(), whole->pdf_per_sr_size(),
                whole->mutable_status());
  append_all(next.pdf_per_sr(), whole->mutable_pdf_per_sr());
  append_cost(next.cost(), whole->mutable_cost());
}

void append(const v1::SampleLeResponse& next, v1::SampleLeResponse* whole) {
  append_status(next.status(), next.pdf_direction_per_sr_size(), whole->pdf_direction_per_sr_size(),
                whole->mutable_status());
  // Every batch has the origin of the scene.
  if (next.points().has_origin_m()) {
    *whole->mutable_points()->mutable_origin_m() = next.points().origin_m();
  }
  append_all(next.points().offsets_m(), whole->mutable_points()->mutable_offsets_m());
  append_all(next.directions(), whole->mutable_directions());
  append_all(next.light_normals(), whole->mutable_light_normals());
  append_all(next.value(), whole->mutable_value());
  append_all(next.pdf_position_per_m2(), whole->mutable_pdf_position_per_m2());
  append_all(next.pdf_direction_per_sr(), whole->mutable_pdf_direction_per_sr());
  append_all(next.light_ids(), whole->mutable_light_ids());
  append_all(next.selection_probability(), whole->mutable_selection_probability());
  append_all(next.spectral_value(), whole->mutable_spectral_value());
  append_cost(next.cost(), whole->mutable_cost());
}

void append(const v1::PdfLeResponse& next, v1::PdfLeResponse* whole) {
  append_status(next.status(), next.pdf_direction_per_sr_size(), whole->pdf_direction_per_sr_size(),
                whole->mutable_status());
  append_all(next.pdf_position_per_m2(), whole->mutable_pdf_position_per_m2());
  append_all(next.pdf_direction_per_sr(), whole->mutable_pdf_direction_per_sr());
  append_cost(next.cost(), whole->mutable_cost());
}

void append(const v1::LeResponse& next, v1::LeResponse* whole) {
  append_status(next.status(), next.light_ids_size(), whole->light_ids_size(),
                whole->mutable_status());
  append_all(next.radiance_cd_m2(), whole->mutable_radiance_cd_m2());
  append_all(next.light_ids(), whole->mutable_light_ids());
  append_all(next.spectral_radiance(), whole->mutable_spectral_radiance());
  append_cost(next.cost(), whole->mutable_cost());
}

void append(const v1::TestVisibilityResponse& next, v1::TestVisibilityResponse* whole) {
  append_bits(next.visible(), next.count(), whole->count(), whole->mutable_visible());
  append_status(next.status(), next.count(), whole->count(), whole->mutable_status());
  whole->set_count(whole->count() + next.count());
  append_all(next.transmittance(), whole->mutable_transmittance());
  append_cost(next.cost(), whole->mutable_cost());
}

void append(const v1::EstimateIrradianceResponse& next, v1::EstimateIrradianceResponse* whole) {
  append_status(next.status(), next.illuminance_lx_size(), whole->illuminance_lx_size(),
                whole->mutable_status());
  append_all(next.irradiance_lx(), whole->mutable_irradiance_lx());
  append_all(next.illuminance_lx(), whole->mutable_illuminance_lx());
  append_all(next.standard_error_lx(), whole->mutable_standard_error_lx());
  append_all(next.zero_bound_lx(), whole->mutable_zero_bound_lx());
  append_all(next.unsampled_bound_lx(), whole->mutable_unsampled_bound_lx());
  // Every batch names surfaces of the same list from its start.
  if (whole->missed_surfaces().empty())
    whole->mutable_missed_surfaces()->CopyFrom(next.missed_surfaces());
  append_all(next.lower_lx(), whole->mutable_lower_lx());
  append_all(next.upper_lx(), whole->mutable_upper_lx());
  append_all(next.spectral_irradiance(), whole->mutable_spectral_irradiance());
  append_all(next.spectral_standard_error(), whole->mutable_spectral_standard_error());
  if (next.has_item_costs()) {
    v1::ItemCosts* costs = whole->mutable_item_costs();
    append_all(next.item_costs().samples(), costs->mutable_samples());
    append_all(next.item_costs().rays(), costs->mutable_rays());
    append_all(next.item_costs().time_s(), costs->mutable_time_s());
  }
  // Every batch lists the same lights in the same order.
  for (int i = 0; i < next.shares_size(); ++i) {
    v1::LightShare* share =
        i < whole->shares_size() ? whole->mutable_shares(i) : whole->add_shares();
    share->set_light_id(next.shares(i).light_id());
    append_all(next.shares(i).illuminance_lx(), share->mutable_illuminance_lx());
    append_all(next.shares(i).standard_error_lx(), share->mutable_standard_error_lx());
    append_all(next.shares(i).lower_lx(), share->mutable_lower_lx());
    append_all(next.shares(i).upper_lx(), share->mutable_upper_lx());
  }
  whole->set_samples(std::max(whole->samples(), next.samples()));
  append_cost(next.cost(), whole->mutable_cost());
}

bool bit(const std::string& bits, std::size_t index) {
  return index / 8 < bits.size() &&
         ((static_cast<unsigned char>(bits[index / 8]) >> (index % 8)) & 1) != 0;
}

void append_bits(const std::string& next, std::size_t count, std::size_t whole_count,
                 std::string* whole) {
  whole->resize((whole_count + count + 7) / 8);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = whole_count + i;
    if (bit(next, i)) (*whole)[at / 8] = static_cast<char>((*whole)[at / 8] | (1 << (at % 8)));
  }
}

}  // namespace lucerna::client
