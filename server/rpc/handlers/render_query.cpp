#include "server/rpc/handlers/render_query.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "proto/common/defaults.h"
#include "proto/common/luminance_moments.h"
#include "proto/common/sample_blocks.h"
#include "proto/common/status_macros.h"
#include "server/queries/queries.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/requested_accuracy.h"
#include "server/visibility/smooth_remarks.h"

namespace lucerna::rpc {
namespace {

// Default if the request and the scene file have no number.
constexpr std::uint32_t kPixelSamples = 64;

/// INVALID_ARGUMENT if `samples_per_block` is set and not allowed.
template <typename Request>
absl::Status check_block(const Request& request) {
  const std::uint32_t block = request.samples_per_block();
  if (!request.has_samples_per_block() ||
      (std::has_single_bit(block) && block <= kMostSamplesPerBlock))
    return absl::OkStatus();
  return bad_field("samples_per_block", block, "a power of two in [1, {}]", kMostSamplesPerBlock);
}

/// Sets the blocks of the query, except with a time budget.
template <typename Request>
absl::Status put_blocks(const Request& request, RenderQuery& query) {
  LUCERNA_RETURN_IF_ERROR(check_block(request));
  TileSettings& settings = query.settings;
  const std::uint32_t block = request.samples_per_block();
  if (query.rule.target) {
    if (request.has_samples_per_block())
      return bad_field("samples_per_block", block,
                       "unset with accuracy.target_error, where each pixel has its own");
    settings.target = query.rule.target;
    settings.block_count =
        std::min<std::uint64_t>(kTargetReplicates, std::bit_floor(query.rule.target->max_samples));
    return absl::OkStatus();
  }
  if (query.rule.time_budget_s) {
    if (request.has_samples_per_block()) {
      if (block > query.most_samples)
        return bad_field("samples_per_block", block, "at most {}, the most samples",
                         query.most_samples);
      query.samples_per_block = block;
    }
    return absl::OkStatus();
  }
  const std::uint32_t samples = query.rule.samples;
  if (request.has_samples_per_block() && samples % block != 0)
    return bad_field("accuracy.samples", samples, "a multiple of samples_per_block = {}", block);
  settings.samples_per_block =
      request.has_samples_per_block() ? block : default_samples_per_block(samples, kTileBlocks);
  settings.block_count = samples / settings.samples_per_block;
  return absl::OkStatus();
}

/// INVALID_ARGUMENT if the request needs independent blocks, but `one_sequence` is set.
template <typename Request>
absl::Status check_sequence(const Request& request) {
  if (!request.one_sequence()) return absl::OkStatus();
  if (request.intervals() || request.accuracy().has_target_error())
    return bad_field("one_sequence", "true",
                     "false with intervals and with accuracy.target_error, which need blocks");
  return absl::OkStatus();
}

/// The requested shutter; nothing: that of the scene file.
template <typename Request>
absl::StatusOr<std::optional<Shutter>> check_shutter(const Scene& scene, const Request& request) {
  if (!request.has_shutter()) return std::optional<Shutter>();
  if (request.has_time_s()) {
    return bad_field("shutter", "set, as well as time_s", "one of the two");
  }
  const v1::Shutter& s = request.shutter();
  const RenderHints& hints = scene.report().hints;
  Shutter shutter{hints.shutter_open_s + s.offset_s(), hints.shutter_close_s + s.offset_s()};
  if (!std::isfinite(shutter.open_s) || !std::isfinite(shutter.close_s)) {
    return bad_field("shutter.offset_s", s.offset_s(),
                     "such that the shutter opens and closes at finite times");
  }
  if (s.has_length_s()) {
    if (!(s.length_s() >= 0)) {
      return bad_field("shutter.length_s", s.length_s(), "[0, inf)");
    }
    shutter.close_s = shutter.open_s + s.length_s();
    if (!std::isfinite(shutter.close_s)) {
      return bad_field("shutter.length_s", s.length_s(),
                       "such that the shutter closes at a finite time");
    }
  }
  return std::optional<Shutter>(shutter);
}

/// The bytes of a plane of n numbers, made by `number(i)`.
template <typename F>
void set_plane(std::string* plane, std::size_t n, F&& number) {
  static_assert(std::endian::native == std::endian::little);
  using Number = decltype(number(n));
  plane->resize(n * sizeof(Number));
  for (std::size_t i = 0; i < n; ++i) {
    const Number v = number(i);
    std::memcpy(plane->data() + i * sizeof v, &v, sizeof v);
  }
}

void set_intervals(const std::vector<FloatInterval>& intervals, v1::Tile* out) {
  set_plane(out->mutable_lower(), intervals.size(),
            [&](std::size_t i) { return intervals[i].lower; });
  set_plane(out->mutable_upper(), intervals.size(),
            [&](std::size_t i) { return intervals[i].upper; });
}

}  // namespace

template <typename Request>
absl::StatusOr<RenderQuery> check_render(const CallContext& context, const Scene& scene,
                                         const Request& request, std::uint32_t proposed) {
  RenderQuery query;
  LUCERNA_RETURN_IF_ERROR(check_time(request.time_s()).status());
  LUCERNA_ASSIGN_OR_RETURN(query.settings.shutter, check_shutter(scene, request));
  LUCERNA_ASSIGN_OR_RETURN(query.rule, check_stop_rule(context, request.accuracy(), proposed));
  query.most_samples = std::bit_floor(context.limits.max_samples);
  LUCERNA_RETURN_IF_ERROR(put_blocks(request, query));
  LUCERNA_RETURN_IF_ERROR(check_sequence(request));
  LUCERNA_ASSIGN_OR_RETURN(query.settings.methods, check_methods(request.accuracy()));
  query.settings.seed = request.seed();
  query.settings.intervals = request.intervals();
  query.settings.one_sequence = request.one_sequence();
  if (request.has_time_s()) query.settings.time_s = request.time_s();
  query.settings.bounces =
      request.has_bounces() ? std::optional(request.bounces()) : hinted_bounces(scene);
  return query;
}

template absl::StatusOr<RenderQuery> check_render(const CallContext&, const Scene&,
                                                  const v1::RenderTileRequest&, std::uint32_t);
template absl::StatusOr<RenderQuery> check_render(const CallContext&, const Scene&,
                                                  const v1::RenderImageRequest&, std::uint32_t);

std::uint32_t proposed_samples(const CallContext& context, const Scene& scene) {
  const auto hint = static_cast<std::uint32_t>(scene.report().hints.samples_per_pixel.value_or(0));
  return std::min(hint > 0 ? hint : kPixelSamples, context.limits.max_samples);
}

std::uint32_t least_samples(const RenderQuery& query) {
  return std::max(std::min(kDefaultBlocks, query.most_samples),
                  query.samples_per_block.value_or(1));
}

std::uint64_t area(const PixelRect& rect) {
  return static_cast<std::uint64_t>(rect.x1 - rect.x0) *
         static_cast<std::uint64_t>(rect.y1 - rect.y0);
}

std::uint64_t pixel_bytes(const TileSettings& settings) {
  if (settings.target)
    return 3 * sizeof(BlockStatistics) + sizeof(std::uint32_t) + sizeof(ConfidenceInterval);
  return 3 * sizeof(BlockStatistics) + (settings.intervals ? sizeof(LuminanceMoments) : 0);
}

void set_tile(const Scene& scene, const TileSettings& settings, std::uint64_t first_block,
              std::uint64_t blocks, const TileResult& result, v1::Tile* out) {
  out->mutable_rect()->set_x0(static_cast<std::uint32_t>(settings.rect.x0));
  out->mutable_rect()->set_y0(static_cast<std::uint32_t>(settings.rect.y0));
  out->mutable_rect()->set_x1(static_cast<std::uint32_t>(settings.rect.x1));
  out->mutable_rect()->set_y1(static_cast<std::uint32_t>(settings.rect.y1));
  out->set_image_width(static_cast<std::uint32_t>(scene.camera().width()));
  out->set_image_height(static_cast<std::uint32_t>(scene.camera().height()));
  if (!settings.target) out->set_samples_per_block(settings.samples_per_block);
  out->set_first_block(first_block);
  out->set_block_count(blocks);
  out->set_may_miss_light(settings.bounces != 0U && may_miss_light(scene));
  const auto& channels = result.channels;
  set_plane(out->mutable_sum(), channels.size(), [&](std::size_t i) { return channels[i].sum; });
  set_plane(out->mutable_deviation(), channels.size(),
            [&](std::size_t i) { return channels[i].deviation; });
  set_plane(out->mutable_samples(), result.samples.size(),
            [&](std::size_t i) { return result.samples[i]; });
  if (settings.target) {
    const float least = least_value(scene.camera().may_be_negative());
    std::vector<FloatInterval> rounded;
    for (const ConfidenceInterval& i : result.intervals)
      rounded.push_back(rounded_outwards(i, least));
    set_intervals(rounded, out);
  } else if (settings.intervals) {
    set_intervals(pixel_intervals(result.moments, blocks, settings.samples_per_block), out);
    *out->mutable_moments() = bytes_of(result.moments);
  }
}

}  // namespace lucerna::rpc
