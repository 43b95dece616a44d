// The items that WireQueries sends, and the conditions for each of its answers.
#include <fmt/format.h>

#include <cmath>

#include "tests/server/extremes/wire_answers.h"
#include "tests/server/extremes/wire_queries.h"

namespace lucerna::testing {
namespace {

void set(const Vec3& v, v1::Vector3* out) {
  out->set_x(v.x);
  out->set_y(v.y);
  out->set_z(v.z);
}

void add(const Vec3f& v, google::protobuf::RepeatedField<float>* out) {
  out->Add(v.x);
  out->Add(v.y);
  out->Add(v.z);
}

/// The server treats denormals as zero.
bool is_zero_to_server(const Vec3f& v) { return max_abs(v) < std::numeric_limits<float>::min(); }

}  // namespace

int WireQueries::batch() {
  return n_.chance(1.0 / 24) ? 513 + static_cast<int>(n_.below(1000)) : batch_;
}

Vec3 WireQueries::place() {
  if (n_.chance(0.5)) return n_.one_of(places_);
  const double r = 2 * summary_.radius_m();
  return vec(summary_.center_m()) + Vec3{n_.uniform(-r, r), n_.uniform(-r, r), n_.uniform(-r, r)};
}

void WireQueries::keep(const Vec3& place) {
  constexpr std::size_t kMost = 256;
  if (!is_finite(place)) return;
  if (places_.size() < kMost)
    places_.push_back(place);
  else
    places_[n_.below(kMost)] = place;
}

void WireQueries::keep(const v1::Points& points) {
  for (int i = 0; i < 4 && 3 * i < points.offsets_m_size(); ++i)
    keep(vec(points.origin_m()) + Vec3(triple(points.offsets_m(), i)));
}

WireQueries::Items WireQueries::points(int n, v1::Points* out) {
  Vec3 origin{};
  switch (n_.below(8)) {
    case 0:
    case 1:
      break;
    case 2:
      origin = {n_.scalar(), n_.scalar(), n_.scalar()};
      break;
    case 3:
      origin = n_.one_of(places_);
      break;
    default:
      origin = vec(summary_.origin_m());
      break;
  }
  if (origin != Vec3{}) set(origin, out->mutable_origin_m());
  Items items;
  for (int i = 0; i < n; ++i) {
    const Vec3f offset = n_.chance(0.5) ? n_.vector() : Vec3f(place() - origin);
    add(offset, out->mutable_offsets_m());
    items.push_back(is_finite(offset) ? Item::kGood : Item::kInvalid);
  }
  return items;
}

void WireQueries::directions(Floats* out, Items& items, const v1::Points* from) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    Vec3f w;
    if (from != nullptr && n_.chance(0.5)) {
      const Vec3 start = vec(from->origin_m()) + Vec3(triple(from->offsets_m(), i));
      w = Vec3f(place() - start);
    } else {
      w = n_.chance(0.5) ? n_.vector() : Vec3f(n_.direction());
    }
    add(w, out);
    if (!is_finite(w) || is_zero_to_server(w)) items[i] = Item::kInvalid;
  }
}

void WireQueries::normals(Floats* out, Items& items) { directions(out, items); }

void WireQueries::sample_values(v1::SampleValues* out, int each, bool named, Items& items) {
  for (Item& item : items) {
    for (int k = 0; k < each; ++k) {
      const float u = n_.sample_value();
      out->add_u(u);
      if (!std::isfinite(u)) item = Item::kInvalid;
    }
    if (!named) out->add_u_light(n_.choosing_value());
  }
}

void WireQueries::wavelengths(google::protobuf::RepeatedField<double>* out, bool arriving) {
  if ((arriving && scene_.has_coloured_media) || n_.chance(0.7)) return;
  for (const double nm : {100.0, 555.0, n_.magnitude(100, 1e6)}) out->Add(nm);
}

void WireQueries::methods(v1::Accuracy* out) {
  // 0 means automatic.  At least half of the requests leave it at that.
  const auto pick = [&](int most) {
    return n_.chance(0.5) ? 0 : static_cast<int>(n_.below(static_cast<std::uint64_t>(most) + 1));
  };
  out->set_area_sampling(static_cast<v1::AreaSampling>(pick(v1::AreaSampling_MAX)));
  out->set_light_selection(static_cast<v1::LightSelection>(pick(v1::LightSelection_MAX)));
  out->set_sampler(static_cast<v1::Sampler>(pick(v1::Sampler_MAX)));
  out->set_combination(static_cast<v1::Combination>(pick(v1::Combination_MAX)));
  out->set_closed_forms(static_cast<v1::ClosedForms>(pick(v1::ClosedForms_MAX)));
  out->set_thin_glass(static_cast<v1::ThinGlass>(pick(v1::ThinGlass_MAX)));
  // No shadow maps: making them takes seconds for each scene.
  if (n_.chance(0.2)) out->set_samples_per_light(1 + static_cast<std::uint32_t>(n_.below(4)));
  if (n_.chance(0.2)) out->set_far_light_radii(n_.magnitude(1e-3, 1e3));
}

std::vector<v1::ItemStatus> WireQueries::statuses(
    const std::string& name, const google::protobuf::RepeatedField<int>& status, const Items& items,
    bool typed) {
  count(name, items.size());
  if (status.empty()) {
    for (std::size_t i = 0; i < items.size(); ++i)
      hold(items[i] != Item::kInvalid, name, i, "an invalid item is answered");
    counts_[{name, v1::ITEM_STATUS_OK}] += items.size();
    return std::vector<v1::ItemStatus>(items.size(), v1::ITEM_STATUS_OK);
  }
  expect(name, status.size(), items.size(), "status");
  if (!failures_.empty()) return std::vector<v1::ItemStatus>(items.size());
  std::vector<v1::ItemStatus> all;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto s = static_cast<v1::ItemStatus>(status[static_cast<int>(i)]);
    all.push_back(s);
    ++counts_[{name, s}];
    const bool invalid = s == v1::ITEM_STATUS_INVALID_INPUT;
    const std::string words = v1::ItemStatus_Name(s);
    hold(v1::ItemStatus_IsValid(s) && s != v1::ITEM_STATUS_UNSPECIFIED, name, i, "no status");
    if (items[i] == Item::kGood) hold(!invalid, name, i, words + " for a valid item");
    if (items[i] == Item::kInvalid) hold(invalid, name, i, words + " for an invalid item");
    if (!typed) {
      const bool inside = name == "EstimateIrradiance" && (s == v1::ITEM_STATUS_INSIDE_SOLID ||
                                                           s == v1::ITEM_STATUS_MAY_MISS_LIGHT);
      hold(s == v1::ITEM_STATUS_OK || s == v1::ITEM_STATUS_OUT_OF_RANGE || inside || invalid, name,
           i, words + ", which this query never returns");
    }
  }
  return all;
}

bool WireQueries::answered(const std::string& name, const grpc::Status& status,
                           const google::protobuf::Message& request,
                           const google::protobuf::Message& response) {
  hold(status.ok(), name, 0,
       fmt::format("{} {}", int(status.error_code()), status.error_message()));
  if (status.ok())
    for (const std::string& wrong : wrong_numbers(response)) hold(false, name, 0, wrong);
  if (!failures_.empty()) failures_.push_back(request.ShortDebugString().substr(0, 200));
  return status.ok();
}

void WireQueries::hold(bool what, const std::string& name, std::size_t item,
                       const std::string& words) {
  if (!what) failures_.push_back(fmt::format("{} item {}: {}", name, item, words));
}

void WireQueries::is_probability(const std::string& name, std::size_t item, double p) {
  hold(p > 0 && p <= 1, name, item, fmt::format("selection_probability = {}", p));
}

/// Without lights in the scene nothing is chosen: 0.
void WireQueries::is_light(const std::string& name, std::size_t item, std::uint64_t id) {
  hold(lights_.empty() ? id == 0 : ids_.contains(id), name, item,
       fmt::format("{} is not a light of the scene", id));
}

bool WireQueries::in_part(const v1::Accuracy& accuracy) const {
  return scene_.has_media || (scene_.has_panes && accuracy.thin_glass() != v1::THIN_GLASS_BLOCKS);
}

void WireQueries::are_shares(const std::string& name, const Floats& transmittance,
                             const std::string& visible, std::size_t items, bool in_part) {
  expect(name, transmittance.size(), in_part ? 3 * items : 0, "transmittance");
  for (std::size_t i = 0; in_part && i < items && failures_.empty(); ++i) {
    if (!bit(visible, i)) is_zero(name, i, transmittance, 3);
    for (std::size_t k = 3 * i; k < 3 * (i + 1); ++k) {
      const float share = transmittance[static_cast<int>(k)];
      hold(share >= 0 && share <= 1, name, i, fmt::format("transmittance {}", share));
      if (share > 0 && share < 1) ++in_part_;
    }
  }
}

void WireQueries::is_unit(const std::string& name, std::size_t item, const Floats& v) {
  const Vec3f w = triple(v, item);
  // Three components, each rounded to float once.
  constexpr double kRounding = 2 * std::numeric_limits<float>::epsilon();
  const double l = length(Vec3(w));
  hold(std::fabs(l - 1) <= kRounding, name, item,
       fmt::format("({}, {}, {}) of length 1 {:+.3g}", w.x, w.y, w.z, l - 1));
}

void WireQueries::is_zero(const std::string& name, std::size_t item, const Floats& v,
                          std::size_t each) {
  for (std::size_t k = item * each; k < (item + 1) * each; ++k)
    hold(v[static_cast<int>(k)] == 0, name, item,
         fmt::format("{} without an answer", v[static_cast<int>(k)]));
}

void WireQueries::expect(const std::string& name, std::size_t size, std::size_t expected,
                         const std::string& field) {
  hold(size == expected, name, 0, fmt::format("{} {}, not {}", size, field, expected));
}

}  // namespace lucerna::testing
