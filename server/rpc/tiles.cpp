#include "server/rpc/tiles.h"

#include <fmt/core.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "proto/sample_blocks.h"
#include "server/queries.h"
#include "server/rpc/checks.h"
#include "server/rpc/errors.h"
#include "server/rpc/methods.h"

namespace lucerna::rpc {
namespace {

constexpr std::uint32_t kDefaultTileSize = 64;
// Where neither the request nor the scene file says.
constexpr std::uint32_t kDefaultSamples = 64;

std::string text(const v1::PixelRect& r) {
  return fmt::format("[{}, {}) x [{}, {})", r.x0(), r.x1(), r.y0(), r.y1());
}

std::uint64_t area(const PixelRect& r) {
  return static_cast<std::uint64_t>(r.x1 - r.x0) * static_cast<std::uint64_t>(r.y1 - r.y0);
}

absl::StatusOr<PixelRect> check_rect(const Context& context, const Scene& scene,
                                     const v1::RenderTileRequest& request) {
  const int width = scene.camera().width(), height = scene.camera().height();
  PixelRect rect{0, 0, width, height};
  if (request.has_rect()) {
    const v1::PixelRect& r = request.rect();
    if (r.x0() >= r.x1() || r.y0() >= r.y1() || r.x1() > static_cast<std::uint32_t>(width) ||
        r.y1() > static_cast<std::uint32_t>(height)) {
      return bad_field("rect", text(r),
                       fmt::format("not empty and within [0, {}) x [0, {})", width, height));
    }
    rect = {static_cast<int>(r.x0()), static_cast<int>(r.y0()), static_cast<int>(r.x1()),
            static_cast<int>(r.y1())};
  }
  if (area(rect) > context.limits.max_tile_pixels) {
    return over_limit("pixels of rect", area(rect), context.limits.max_tile_pixels);
  }
  if (auto s = check_answer_size(context, "pixels of rect", area(rect), tile_size()); !s.ok()) {
    return s;
  }
  return rect;
}

/// What the scene file proposes, where it does and the limit allows.
std::uint32_t proposed_samples(const Context& context, const Scene& scene) {
  const auto hint = static_cast<std::uint32_t>(scene.hints().samples_per_pixel.value_or(0));
  return std::min(hint > 0 ? hint : kDefaultSamples, context.limits.max_samples);
}

/// `samples_per_block` as asked for, or the default.
template <typename Request>
absl::StatusOr<std::uint32_t> check_block(std::uint32_t samples, const Request& request) {
  if (!request.has_samples_per_block()) return default_samples_per_block(samples, kTileReplicates);
  const std::uint32_t block = request.samples_per_block();
  if (!std::has_single_bit(block) || block > kMostSamplesPerBlock) {
    return bad_field("samples_per_block", fmt::format("{}", block),
                     fmt::format("a power of two in [1, {}]", kMostSamplesPerBlock));
  }
  if (samples % block != 0) {
    return bad_field("accuracy.samples", fmt::format("{}", samples),
                     fmt::format("a multiple of samples_per_block = {}", block));
  }
  return block;
}

/// What tiles and pictures are asked for in the same words.
struct RenderQuery {
  TileSettings settings;  ///< without rectangle and blocks
  std::uint32_t samples = 0;
};

/// Nothing where the scene file's is meant.
template <typename Request>
absl::StatusOr<std::optional<Shutter>> check_shutter(const Scene& scene, const Request& request) {
  if (!request.has_shutter()) return std::optional<Shutter>();
  if (request.has_time_s()) {
    return bad_field("shutter", "a shutter beside time_s", "one of both");
  }
  const v1::Shutter& s = request.shutter();
  const RenderHints& hints = scene.hints();
  Shutter shutter{hints.shutter_open_s + s.offset_s(), hints.shutter_close_s + s.offset_s()};
  if (!std::isfinite(shutter.open_s) || !std::isfinite(shutter.close_s)) {
    return bad_field("shutter.offset_s", fmt::format("{}", s.offset_s()),
                     "such that the shutter opens and closes at finite times");
  }
  if (s.has_length_s()) {
    if (!(s.length_s() >= 0)) {
      return bad_field("shutter.length_s", fmt::format("{}", s.length_s()), "[0, inf)");
    }
    shutter.close_s = shutter.open_s + s.length_s();
    if (!std::isfinite(shutter.close_s)) {
      return bad_field("shutter.length_s", fmt::format("{}", s.length_s()),
                       "such that the shutter closes at a finite time");
    }
  }
  return std::optional<Shutter>(shutter);
}

/// `proposed`: samples where the request does not say.
template <typename Request>
absl::StatusOr<RenderQuery> check_render(const Context& context, const Scene& scene,
                                         const Request& request, std::uint32_t proposed) {
  if (auto s = check_time(request.has_time_s(), request.time_s()); !s.ok()) return s;
  const auto shutter = check_shutter(scene, request);
  if (!shutter.ok()) return shutter.status();
  const auto samples = check_samples(context, request.accuracy(), proposed);
  if (!samples.ok()) return samples.status();
  const auto block = check_block(*samples, request);
  if (!block.ok()) return block.status();
  const auto methods = check_methods(request.accuracy());
  if (!methods.ok()) return methods.status();
  RenderQuery query;
  query.samples = *samples;
  query.settings.samples_per_block = *block;
  query.settings.methods = *methods;
  query.settings.seed = request.seed();
  if (request.has_time_s()) query.settings.time_s = request.time_s();
  query.settings.shutter = *shutter;
  query.settings.bounces =
      request.has_bounces() ? std::optional(request.bounces()) : hinted_bounces(scene);
  return query;
}

void put_double(double v, char* out) {
  static_assert(std::endian::native == std::endian::little);
  std::memcpy(out, &v, sizeof v);
}

void set_tile(const Scene& scene, const TileSettings& settings, std::uint64_t first_block,
              std::uint64_t blocks, const std::vector<BlockStatistics>& channels, v1::Tile* out) {
  out->mutable_rect()->set_x0(static_cast<std::uint32_t>(settings.rect.x0));
  out->mutable_rect()->set_y0(static_cast<std::uint32_t>(settings.rect.y0));
  out->mutable_rect()->set_x1(static_cast<std::uint32_t>(settings.rect.x1));
  out->mutable_rect()->set_y1(static_cast<std::uint32_t>(settings.rect.y1));
  out->set_image_width(static_cast<std::uint32_t>(scene.camera().width()));
  out->set_image_height(static_cast<std::uint32_t>(scene.camera().height()));
  out->set_samples_per_block(settings.samples_per_block);
  out->set_first_block(first_block);
  out->set_block_count(blocks);
  std::string& sum = *out->mutable_sum();
  std::string& deviation = *out->mutable_deviation();
  sum.resize(channels.size() * sizeof(double));
  deviation.resize(channels.size() * sizeof(double));
  for (std::size_t i = 0; i < channels.size(); ++i) {
    put_double(channels[i].sum, sum.data() + sizeof(double) * i);
    put_double(channels[i].deviation, deviation.data() + sizeof(double) * i);
  }
}

}  // namespace

Prepared render_tile(const Context& context, const v1::RenderTileRequest& request,
                     v1::RenderTileResponse* response) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  const auto rect = check_rect(context, **scene, request);
  if (!rect.ok()) return rect.status();
  const auto query =
      check_render(context, **scene, request, std::bit_floor(proposed_samples(context, **scene)));
  if (!query.ok()) return query.status();
  TileSettings settings = query->settings;
  const std::uint32_t samples = query->samples, block = settings.samples_per_block;
  if (!std::has_single_bit(samples / block)) {
    return bad_field("accuracy.samples", fmt::format("{}", samples),
                     fmt::format("a power of two times samples_per_block = {}; a picture of other "
                                 "counts is made of several tiles",
                                 block));
  }
  if (request.first_sample() % samples != 0) {
    return bad_field("first_sample", fmt::format("{}", request.first_sample()),
                     fmt::format("a multiple of accuracy.samples = {}", samples));
  }
  // Samples are numbered in 32 bits within the sampler's sequences.
  constexpr std::uint64_t kMaxFirst = std::uint64_t{1} << 40;
  if (request.first_sample() > kMaxFirst) {
    return bad_field("first_sample", fmt::format("{}", request.first_sample()),
                     fmt::format("[0, {}]", kMaxFirst));
  }
  settings.rect = *rect;
  settings.first_block = request.first_sample() / block;
  settings.block_count = samples / block;

  Task task;
  task.bulk = true;
  task.cost = response->mutable_cost();
  task.run = [scene = *scene, settings, response](const std::stop_token& stop) -> absl::Status {
    const TileResult result = lucerna::render_tile(*scene, settings, stop);
    if (result.stopped) return absl::CancelledError("stopped");
    set_tile(*scene, settings, settings.first_block, settings.block_count, result.channels,
             response->mutable_tile());
    set_counts(response->mutable_cost(), result.work);
    return absl::OkStatus();
  };
  return task;
}

absl::StatusOr<ImageRender> ImageRender::create(const Context& context,
                                                const v1::RenderImageRequest& request) {
  const auto scene = find_scene(context, request.scene_id());
  if (!scene.ok()) return scene.status();
  const auto query = check_render(context, **scene, request, proposed_samples(context, **scene));
  if (!query.ok()) return query.status();
  const std::uint64_t edge = request.has_tile_size() ? request.tile_size() : kDefaultTileSize;
  if (edge == 0 || edge * edge > context.limits.max_tile_pixels) {
    return bad_field(
        "tile_size", fmt::format("{}", edge),
        fmt::format("at least 1, its square at most {}", context.limits.max_tile_pixels));
  }
  const int width = (*scene)->camera().width(), height = (*scene)->camera().height();
  // The statistics of so many pixels take 3 GiB; larger pictures are asked for tile by tile.
  constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 26;
  const std::uint64_t pixels =
      static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (pixels > kMaxPixels) return over_limit("pixels of the picture", pixels, kMaxPixels);
  const std::uint64_t tile_pixels =
      std::min<std::uint64_t>(edge, width) * std::min<std::uint64_t>(edge, height);
  if (auto s = check_answer_size(context, "pixels of a tile", tile_pixels, tile_size()); !s.ok()) {
    return s;
  }
  // Each has a message and a header of its own.
  constexpr std::uint64_t kMaxTiles = 1 << 16;
  const auto across = [edge](int size) {
    return (static_cast<std::uint64_t>(size) + edge - 1) / edge;
  };
  if (const std::uint64_t tiles = across(width) * across(height); tiles > kMaxTiles) {
    return bad_field(
        "tile_size", fmt::format("{}", edge),
        fmt::format("such that the picture has at most {} tiles, not {}", kMaxTiles, tiles));
  }

  ImageRender render;
  render.scene_ = *scene;
  render.settings_ = query->settings;
  render.blocks_ = query->samples / query->settings.samples_per_block;
  render.pass_end_ = request.final_only() ? render.blocks_ : 1;
  const int step = static_cast<int>(edge);
  for (int y = 0; y < height; y += step) {
    for (int x = 0; x < width; x += step) {
      const PixelRect rect{x, y, std::min(x + step, width), std::min(y + step, height)};
      render.tiles_.push_back(rect);
      render.merged_.emplace_back(0, 3 * area(rect));
    }
  }
  return render;
}

absl::Status ImageRender::next(const std::stop_token& stop, v1::RenderImageResponse* response) {
  settings_.rect = tiles_[tile_];
  BlockMerger& merged = merged_[tile_];
  for (std::uint64_t first = pass_begin_; first < pass_end_;) {
    settings_.first_block = first;
    settings_.block_count = aligned_run(first, pass_end_);
    TileResult result = lucerna::render_tile(*scene_, settings_, stop);
    if (result.stopped) return absl::CancelledError("stopped");
    work_ += result.work;
    if (!merged.add(first, settings_.block_count, std::move(result.channels))) {
      return absl::InternalError("tiles do not follow each other");
    }
    first += settings_.block_count;
  }
  set_tile(*scene_, settings_, 0, pass_end_, merged.total(), response->mutable_tile());
  samples_done_ += area(settings_.rect) * (pass_end_ - pass_begin_) * settings_.samples_per_block;
  response->set_samples_done(samples_done_);
  response->set_samples_total(static_cast<std::uint64_t>(scene_->camera().width()) *
                              static_cast<std::uint64_t>(scene_->camera().height()) * blocks_ *
                              settings_.samples_per_block);
  set_counts(response->mutable_cost(), work_);
  if (++tile_ == tiles_.size() && pass_end_ < blocks_) end_pass();
  return absl::OkStatus();
}

void ImageRender::end_pass() {
  tile_ = 0;
  pass_begin_ = pass_end_;
  pass_end_ = std::min(2 * pass_end_, blocks_);
}

}  // namespace lucerna::rpc
