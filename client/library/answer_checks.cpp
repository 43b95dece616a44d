#include "client/library/answer_checks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>
#include <type_traits>
#include <vector>

#include "client/library/batch_parts.h"
#include "proto/common/answer_size.h"
#include "proto/common/luminance_moments.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using google::protobuf::RepeatedField;

constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 30;

enum class Need { kAlways, kMayBeEmpty };

bool is_finite(const Message& message, const FieldDescriptor* field) {
  const Reflection& r = *message.GetReflection();
  const int count = field->is_repeated() ? r.FieldSize(message, field) : 1;
  for (int i = 0; i < count; ++i) {
    double value = 0;
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      value = field->is_repeated() ? r.GetRepeatedDouble(message, field, i)
                                   : r.GetDouble(message, field);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT) {
      value =
          field->is_repeated() ? r.GetRepeatedFloat(message, field, i) : r.GetFloat(message, field);
    }
    if (!std::isfinite(value)) return false;
  }
  return true;
}

/// All numbers of a message and of the messages in it are finite.
absl::Status check_finite(const Message& message) {
  const Reflection& r = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  r.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (!is_finite(message, field))
      return broken_protocol(message.GetDescriptor()->name() + "." + field->name() +
                             ": has a number that is not finite");
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      LUCERNA_RETURN_IF_ERROR(check_finite(r.GetMessage(message, field)));
      continue;
    }
    for (int i = 0; i < r.FieldSize(message, field); ++i)
      LUCERNA_RETURN_IF_ERROR(check_finite(r.GetRepeatedMessage(message, field, i)));
  }
  return absl::OkStatus();
}

/// The checks of one answer; the first that fails counts.
class Check {
 public:
  explicit Check(const Message& answer) : name_(answer.GetDescriptor()->name()) {}

  /// An array has this many entries, all finite.
  template <class T>
  Check& array(const char* field, const RepeatedField<T>& values, std::uint64_t count,
               Need need = Need::kAlways) {
    size(field, static_cast<std::uint64_t>(values.size()), count, need);
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::all_of(values.begin(), values.end(), [](T v) { return std::isfinite(v); }))
        fail(field, "has a number that is not finite");
    }
    return *this;
  }
  Check& bits(const char* field, const std::string& bits, std::uint64_t count,
              Need need = Need::kAlways) {
    return size(field, bits.size(), (count + 7) / 8, need);
  }
  Check& size(const char* field, std::uint64_t size, std::uint64_t must, Need need) {
    if (size != must && (size > 0 || need == Need::kAlways))
      fail(field, "has " + std::to_string(size) + " entries, must be " + std::to_string(must) +
                      (need == Need::kMayBeEmpty ? " or 0" : ""));
    return *this;
  }
  Check& finite(const Message& part) {
    if (status_.ok()) status_ = check_finite(part);
    return *this;
  }
  void fail(const std::string& field, const std::string& what) {
    if (status_.ok()) status_ = broken_protocol(name_ + "." + field + ": " + what);
  }
  const absl::Status& status() const { return status_; }

 private:
  std::string name_;
  absl::Status status_;
};

Need if_set(bool needed) { return needed ? Need::kAlways : Need::kMayBeEmpty; }

std::string text_of(const Message& message, const char* field_name) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(field_name);
  return field == nullptr ? "" : message.GetReflection()->GetString(message, field);
}

/// A page before the last one has entries, and is not its own next page.  Otherwise a client would
/// ask for ever.
absl::Status check_page(const Message& request, const Message& answer) {
  const std::string next = text_of(answer, "next_page_token");
  if (next.empty()) return absl::OkStatus();
  if (next == text_of(request, "page_token") ||
      answer.GetReflection()->FieldSize(answer, answer.GetDescriptor()->field(0)) == 0)
    return broken_protocol(answer.GetDescriptor()->name() +
                           ".next_page_token: the list has no end");
  return absl::OkStatus();
}

/// Whether all numbers of a plane are finite; of `least` and above.
template <typename Number>
bool plane_is_finite(const std::string& bytes, double least, double most) {
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(Number)) {
    Number value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    if (!(value >= least && value <= most)) return false;
  }
  return true;
}

}  // namespace

absl::Status broken_protocol(const std::string& what) {
  return absl::InternalError("the server broke the protocol: " + what);
}

absl::Status check_answer(const v1::SampleLiRequest& request, const v1::SampleLiResponse& answer) {
  const std::uint64_t receivers = item_count(request), waves = request.wavelengths_nm_size();
  const bool counted =
      request.accuracy().has_target_error() || request.accuracy().has_time_budget_s();
  if (receivers == 0 && request.receivers().offsets_m_size() > 0) return absl::OkStatus();
  const auto& counts = answer.estimates().samples();
  const std::uint64_t n = counted ? std::accumulate(counts.begin(), counts.end(), std::uint64_t{0})
                                  : receivers * std::max(1U, request.accuracy().samples());
  const Need chosen = if_set(!names_light(request));
  Check check(answer);
  if (counted) {
    const v1::ReceiverEstimates& e = answer.estimates();
    check.array("estimates.samples", e.samples(), receivers)
        .array("estimates.illuminance_lx", e.illuminance_lx(), receivers)
        .array("estimates.standard_error_lx", e.standard_error_lx(), receivers)
        .array("estimates.lower_lx", e.lower_lx(), receivers)
        .array("estimates.upper_lx", e.upper_lx(), receivers)
        .array("estimates.spectral_irradiance", e.spectral_irradiance(), receivers * waves)
        .array("estimates.spectral_standard_error", e.spectral_standard_error(), receivers * waves)
        .array("estimates.status", e.status(), receivers, Need::kMayBeEmpty);
  }
  check.array("value", answer.value(), 3 * n)
      .array("wi", answer.wi(), 3 * n)
      .array("distance_m", answer.distance_m(), n)
      .array("light_offsets_m", answer.light_offsets_m(), 3 * n)
      .array("light_normals", answer.light_normals(), 3 * n)
      .array("pdf_per_sr", answer.pdf_per_sr(), n)
      .bits("delta", answer.delta(), n, Need::kMayBeEmpty)
      .bits("visible", answer.visible(), n, if_set(request.test_visibility()))
      .array("light_ids", answer.light_ids(), n, chosen)
      .array("selection_probability", answer.selection_probability(), n, chosen)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .array("spectral_value", answer.spectral_value(), n * waves)
      .array("transmittance", answer.transmittance(), 3 * n, Need::kMayBeEmpty);
  return check.finite(answer.cost()).status();
}

absl::Status check_answer(const v1::PdfLiRequest& request, const v1::PdfLiResponse& answer) {
  const std::uint64_t n = item_count(request);
  if (n == 0 && request.receivers().offsets_m_size() > 0) return absl::OkStatus();
  return Check(answer)
      .array("pdf_per_sr", answer.pdf_per_sr(), n)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .finite(answer.cost())
      .status();
}

absl::Status check_answer(const v1::SampleLeRequest& request, const v1::SampleLeResponse& answer) {
  const std::uint64_t n = item_count(request), waves = request.wavelengths_nm_size();
  if (n == 0 && request.count() > 0) return absl::OkStatus();
  const Need chosen = if_set(!names_light(request));
  return Check(answer)
      .array("points.offsets_m", answer.points().offsets_m(), 3 * n)
      .array("directions", answer.directions(), 3 * n)
      .array("light_normals", answer.light_normals(), 3 * n)
      .array("value", answer.value(), 3 * n)
      .array("pdf_position_per_m2", answer.pdf_position_per_m2(), n)
      .array("pdf_direction_per_sr", answer.pdf_direction_per_sr(), n)
      .array("light_ids", answer.light_ids(), n, chosen)
      .array("selection_probability", answer.selection_probability(), n, chosen)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .array("spectral_value", answer.spectral_value(), n * waves)
      .finite(answer.points().origin_m())
      .finite(answer.cost())
      .status();
}

absl::Status check_answer(const v1::PdfLeRequest& request, const v1::PdfLeResponse& answer) {
  const std::uint64_t n = item_count(request);
  if (n == 0 && request.points().offsets_m_size() > 0) return absl::OkStatus();
  return Check(answer)
      .array("pdf_position_per_m2", answer.pdf_position_per_m2(), n)
      .array("pdf_direction_per_sr", answer.pdf_direction_per_sr(), n)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .finite(answer.cost())
      .status();
}

absl::Status check_answer(const v1::LeRequest& request, const v1::LeResponse& answer) {
  const std::uint64_t n = item_count(request);
  if (n == 0 && request.points().offsets_m_size() > 0) return absl::OkStatus();
  return Check(answer)
      .array("radiance_cd_m2", answer.radiance_cd_m2(), 3 * n)
      .array("light_ids", answer.light_ids(), n)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .array("spectral_radiance", answer.spectral_radiance(), n * request.wavelengths_nm_size())
      .finite(answer.cost())
      .status();
}

absl::Status check_answer(const v1::TestVisibilityRequest& request,
                          const v1::TestVisibilityResponse& answer) {
  const std::uint64_t n = item_count(request);
  const bool empty =
      request.rays().from().offsets_m().empty() && request.segments().from().offsets_m().empty();
  if (n == 0 && !empty) return absl::OkStatus();
  Check check(answer);
  if (answer.count() != n)
    check.fail("count", std::to_string(answer.count()) + ", must be " + std::to_string(n));
  check.bits("visible", answer.visible(), n)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .array("transmittance", answer.transmittance(), 3 * n, Need::kMayBeEmpty);
  return check.finite(answer.cost()).status();
}

absl::Status check_answer(const v1::EstimateIrradianceRequest& request,
                          const v1::EstimateIrradianceResponse& answer) {
  const std::uint64_t n = item_count(request), waves = request.wavelengths_nm_size();
  if (n == 0 && request.receivers().offsets_m_size() > 0) return absl::OkStatus();
  const bool target = request.accuracy().has_target_error();
  Check check(answer);
  check.array("irradiance_lx", answer.irradiance_lx(), 3 * n)
      .array("illuminance_lx", answer.illuminance_lx(), n)
      .array("standard_error_lx", answer.standard_error_lx(), n, Need::kMayBeEmpty)
      .array("zero_bound_lx", answer.zero_bound_lx(), n)
      .array("lower_lx", answer.lower_lx(), n, if_set(target))
      .array("upper_lx", answer.upper_lx(), answer.lower_lx_size())
      .array("unsampled_bound_lx", answer.unsampled_bound_lx(), n, Need::kMayBeEmpty)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .array("spectral_irradiance", answer.spectral_irradiance(), n * waves)
      .array("spectral_standard_error", answer.spectral_standard_error(), n * waves,
             Need::kMayBeEmpty)
      .array("item_costs.samples", answer.item_costs().samples(), n, if_set(target))
      .array("item_costs.rays", answer.item_costs().rays(), n, Need::kMayBeEmpty)
      .array("item_costs.time_s", answer.item_costs().time_s(), n, Need::kMayBeEmpty);
  if (answer.shares_size() > 0 && !request.per_light()) check.fail("shares", "was not requested");
  for (const v1::LightShare& share : answer.shares()) {
    check.array("shares.illuminance_lx", share.illuminance_lx(), n)
        .array("shares.standard_error_lx", share.standard_error_lx(), n, Need::kMayBeEmpty)
        .array("shares.lower_lx", share.lower_lx(), n, Need::kMayBeEmpty)
        .array("shares.upper_lx", share.upper_lx(), share.lower_lx_size());
  }
  return check.finite(answer.cost()).status();
}

absl::Status check_answer(const v1::FindSurfacesRequest& request,
                          const v1::FindSurfacesResponse& answer) {
  const std::uint64_t n = request.places_size() / 2;
  return Check(answer)
      .array("points.offsets_m", answer.points().offsets_m(), 3 * n)
      .array("normals", answer.normals(), 3 * n)
      .bits("found", answer.found(), n)
      .array("light_ids", answer.light_ids(), n)
      .array("status", answer.status(), n, Need::kMayBeEmpty)
      .finite(answer.points().origin_m())
      .finite(answer.cost())
      .status();
}

absl::Status check_answer(const v1::RenderTileRequest& request,
                          const v1::RenderTileResponse& answer) {
  const v1::Tile& tile = answer.tile();
  if (absl::Status s = check_tile(tile); !s.ok()) return broken_protocol(std::string(s.message()));
  if (request.has_rect() && !same_rect(request.rect(), tile.rect()))
    return broken_protocol(describe(tile.rect()) + ": requested was " + describe(request.rect()));
  const v1::Accuracy& accuracy = request.accuracy();
  const std::uint64_t length = tile.samples_per_block();
  if (accuracy.has_target_error() != !tile.samples().empty() ||
      (request.intervals() && !accuracy.has_target_error()) != !tile.moments().empty())
    return broken_protocol(describe(tile.rect()) + ": has other planes than requested");
  if ((accuracy.has_samples() && tile.block_count() * length != accuracy.samples()) ||
      tile.first_block() * length != request.first_sample())
    return broken_protocol(describe(tile.rect()) + ": has " + std::to_string(tile.block_count()) +
                           " blocks from " + std::to_string(tile.first_block()) + " of " +
                           std::to_string(length) + " samples, others than requested");
  return check_finite(answer.cost());
}

absl::Status check_answer(const v1::FindMissingAssetsRequest& request,
                          const v1::FindMissingAssetsResponse& answer) {
  Check check(answer);
  check.array("received_bytes", answer.received_bytes(), answer.missing_sha256_size());
  const std::set<std::string> asked(request.sha256().begin(), request.sha256().end());
  for (const std::string& digest : answer.missing_sha256())
    if (!asked.contains(digest))
      check.fail("missing_sha256", "has a digest that was not requested");
  return check.status();
}

absl::Status check_answer(const Message& request, const Message& answer) {
  LUCERNA_RETURN_IF_ERROR(check_page(request, answer));
  return check_finite(answer);
}

bool same_rect(const v1::PixelRect& a, const v1::PixelRect& b) {
  return a.x0() == b.x0() && a.y0() == b.y0() && a.x1() == b.x1() && a.y1() == b.y1();
}

std::string describe(const v1::PixelRect& rect) {
  return "tile [" + std::to_string(rect.x0()) + ", " + std::to_string(rect.x1()) + ") x [" +
         std::to_string(rect.y0()) + ", " + std::to_string(rect.y1()) + ")";
}

std::size_t pixel_count(const v1::PixelRect& rect) {
  return std::size_t{rect.x1() - rect.x0()} * (rect.y1() - rect.y0());
}

absl::Status check_tile(const v1::Tile& tile) {
  const v1::PixelRect& rect = tile.rect();
  const std::string name = describe(rect);
  if (std::uint64_t{tile.image_width()} * tile.image_height() > kMaxPixels) {
    return absl::InvalidArgumentError(name + ": the picture has more than 2^30 pixels");
  }
  if (rect.x0() >= rect.x1() || rect.y0() >= rect.y1() || rect.x1() > tile.image_width() ||
      rect.y1() > tile.image_height()) {
    return absl::InvalidArgumentError(name + ": empty, or not within the picture of " +
                                      std::to_string(tile.image_width()) + " x " +
                                      std::to_string(tile.image_height()) + " pixels");
  }
  if (tile.block_count() == 0) return absl::InvalidArgumentError(name + ": block_count = 0");
  const std::size_t bytes = pixel_count(rect) * 3 * sizeof(double);
  if (tile.sum().size() != bytes || tile.deviation().size() != bytes) {
    return absl::InvalidArgumentError(
        name + ": sum and deviation have " + std::to_string(tile.sum().size()) + " and " +
        std::to_string(tile.deviation().size()) + " bytes, must be " + std::to_string(bytes));
  }
  const std::size_t each = pixel_count(rect) * sizeof(std::uint32_t);
  const bool target = !tile.samples().empty();
  const bool intervals = target || !tile.lower().empty() || !tile.upper().empty();
  if ((target && tile.samples().size() != each) ||
      (intervals && (tile.lower().size() != each || tile.upper().size() != each)))
    return absl::InvalidArgumentError(
        name + ": samples, lower and upper have " + std::to_string(tile.samples().size()) + ", " +
        std::to_string(tile.lower().size()) + " and " + std::to_string(tile.upper().size()) +
        " bytes, must be 0 or " + std::to_string(each) + "; lower and upper belong together");
  const std::size_t moments = intervals && !target ? pixel_count(rect) * kMomentBytes : 0;
  if (tile.moments().size() != moments)
    return absl::InvalidArgumentError(name + ": moments has " +
                                      std::to_string(tile.moments().size()) + " bytes, must be " +
                                      std::to_string(moments));
  if (target && tile.first_block() != 0)
    return absl::InvalidArgumentError(name +
                                      ": first_block = " + std::to_string(tile.first_block()) +
                                      ", allowed with a target error: 0");
  // Pixels and standard errors are floats.
  const double most = std::numeric_limits<float>::max();
  const auto blocks = static_cast<double>(tile.block_count());
  if (!plane_is_finite<double>(tile.sum(), -most * blocks, most * blocks) ||
      !plane_is_finite<double>(tile.deviation(), 0, most * most * blocks) ||
      !plane_is_finite<float>(tile.lower(), -most, most) ||
      !plane_is_finite<float>(tile.upper(), -most, most) ||
      !plane_is_finite<double>(tile.moments(), std::numeric_limits<double>::lowest(),
                               std::numeric_limits<double>::max()))
    return absl::InvalidArgumentError(name + ": has a number that is not finite or too large");
  return absl::OkStatus();
}

absl::Status ImageCheck::add(const v1::RenderImageResponse& response) {
  LUCERNA_RETURN_IF_ERROR(check_finite(response.cost()));
  if (!response.has_tile()) return absl::OkStatus();
  const v1::Tile& tile = response.tile();
  if (absl::Status s = check_tile(tile); !s.ok()) return broken_protocol(std::string(s.message()));
  const v1::PixelRect& rect = tile.rect();
  if (tiles_.empty()) {
    width_ = tile.image_width();
    height_ = tile.image_height();
  }
  if (tile.image_width() != width_ || tile.image_height() != height_)
    return broken_protocol(describe(rect) + ": the size of the picture changed");
  if (tile.first_block() != 0)
    return broken_protocol(describe(rect) +
                           ": first_block = " + std::to_string(tile.first_block()) + ", must be 0");
  const auto [seen, is_new] =
      tiles_.try_emplace({rect.x0(), rect.y0()}, Seen{rect, tile.block_count()});
  if (is_new) {
    pixels_ += pixel_count(rect);
    if (pixels_ > std::uint64_t{width_} * height_)
      return broken_protocol(describe(rect) + ": overlaps other tiles");
    return absl::OkStatus();
  }
  if (!same_rect(seen->second.rect, rect) || tile.block_count() <= seen->second.blocks)
    return broken_protocol(describe(rect) + ": came again without more blocks");
  seen->second.blocks = tile.block_count();
  return absl::OkStatus();
}

absl::Status ImageCheck::end() const {
  const std::uint64_t all = std::uint64_t{width_} * height_;
  if (pixels_ == all && all > 0) return absl::OkStatus();
  return broken_protocol("the picture ended with " + std::to_string(pixels_) + " of " +
                         std::to_string(all) + " pixels");
}

}  // namespace lucerna::client
