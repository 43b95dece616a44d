#include "server/rpc/handlers/render_image_handler.h"

#include <algorithm>
#include <bit>

#include "proto/common/sample_blocks.h"
#include "proto/common/status_macros.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"
#include "server/runtime/time_budget.h"

namespace lucerna::rpc {
namespace {

constexpr std::uint32_t kDefaultTileSize = 64;
// Block size and first blocks with a time budget.  Two blocks are the least number with a scatter,
// and have the 16 samples that the contract promises.
constexpr std::uint32_t kTimedBlock = 8;
constexpr std::uint64_t kWaitedForBlocks = 2;
// The statistics of this many pixels take 3 GiB, and with intervals half as many take 3.5 GiB.
// RenderTile renders larger pictures tile by tile.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;
// Each tile has its own message and header.
constexpr std::uint64_t kMostTiles = 1 << 16;

/// The edge of the tiles.  INVALID_ARGUMENT or RESOURCE_EXHAUSTED for a picture or tiles over a
/// limit.
absl::StatusOr<int> check_tiles(const CallContext& context, const Camera& camera,
                                const v1::RenderImageRequest& request) {
  const std::uint64_t edge = request.has_tile_size() ? request.tile_size() : kDefaultTileSize;
  if (edge == 0 || edge * edge > context.limits.max_tile_pixels) {
    return bad_field("tile_size", edge, "at least 1, its square at most {}",
                     context.limits.max_tile_pixels);
  }
  const auto width = static_cast<std::uint64_t>(camera.width());
  const auto height = static_cast<std::uint64_t>(camera.height());
  const std::uint64_t most = request.intervals() ? kMostPixels / 2 : kMostPixels;
  LUCERNA_RETURN_IF_ERROR(check_limit("pixels of the picture", width * height, most));
  LUCERNA_RETURN_IF_ERROR(check_answer_size(context, "pixels of a tile",
                                            std::min(edge, width) * std::min(edge, height),
                                            tile_size(request.accuracy(), request.intervals())));
  const auto across = [edge](std::uint64_t size) { return (size + edge - 1) / edge; };
  if (const std::uint64_t tiles = across(width) * across(height); tiles > kMostTiles) {
    return bad_field("tile_size", edge, "such that the picture has at most {} tiles, not {}",
                     kMostTiles, tiles);
  }
  return static_cast<int>(edge);
}

}  // namespace

absl::StatusOr<RenderImageHandler> RenderImageHandler::create(
    const CallContext& context, const v1::RenderImageRequest& request) {
  RenderImageHandler render;
  LUCERNA_ASSIGN_OR_RETURN(render.scene_, find_scene(context, request.scene_id()));
  const Scene& scene = *render.scene_;
  LUCERNA_ASSIGN_OR_RETURN(render.query_,
                           check_render(context, scene, request, proposed_samples(context, scene)));
  LUCERNA_ASSIGN_OR_RETURN(const int edge, check_tiles(context, scene.camera(), request));
  render.final_only_ = request.final_only();
  const int width = scene.camera().width(), height = scene.camera().height();
  TileSettings& settings = render.query_.settings;
  render.blocks_ = settings.block_count;
  if (render.is_timed()) {
    settings.samples_per_block =
        render.query_.samples_per_block.value_or(std::min(kTimedBlock, render.query_.most_samples));
    render.blocks_ = render.query_.most_samples / settings.samples_per_block;
  } else if (!settings.target) {
    render.samples_total_ =
        area({0, 0, width, height}) * render.blocks_ * settings.samples_per_block;
  }
  const bool at_once = settings.target || (request.final_only() && !render.is_timed());
  render.pass_end_ = at_once ? render.blocks_ : 1;
  for (int y = 0; y < height; y += edge) {
    for (int x = 0; x < width; x += edge) {
      const PixelRect rect{x, y, std::min(x + edge, width), std::min(y + edge, height)};
      render.tiles_.push_back(rect);
      if (settings.target) continue;
      render.merged_.emplace_back(0, 3 * area(rect));
      if (settings.intervals) render.moments_.emplace_back(0, area(rect));
    }
  }
  render.memory_ = context.scenes.count_call(scene);
  LUCERNA_RETURN_IF_ERROR(load_error(render.count(render.pass_end_)));
  return render;
}

absl::Status RenderImageHandler::count(std::uint64_t pass_end) {
  std::uint64_t runs = 0;  // of blocks, of each pixel, between two passes
  if (is_timed()) {
    runs = static_cast<std::uint64_t>(std::popcount(pass_end));
  } else if (!query_.settings.target && pass_end < blocks_) {
    runs = 1;  // passes but the last end at powers of two
  }
  // The tile in work has runs that are not merged yet.  Beside it there are its sum and its
  // message, and tiles on their way to the client.
  constexpr std::uint64_t kCopies = 5;
  const std::uint64_t of_tile =
      kCopies + (query_.settings.target ? 1 : static_cast<std::uint64_t>(std::popcount(blocks_)));
  const std::uint64_t needed =
      (runs * pixels() + of_tile * area(tiles_.front())) * pixel_bytes(query_.settings);
  if (needed <= counted_) return absl::OkStatus();
  LUCERNA_RETURN_IF_ERROR(memory_->claim(needed - counted_));
  counted_ = needed;
  return absl::OkStatus();
}

std::uint64_t RenderImageHandler::pixels() const {
  return area({0, 0, scene_->camera().width(), scene_->camera().height()});
}

absl::Status RenderImageHandler::next(const std::stop_token& stop,
                                      v1::RenderImageResponse* response) {
  TileSettings& settings = query_.settings;
  settings.rect = tiles_[tile_];
  if (!begin_) begin_ = pass_start_ = Clock::now();
  if (settings.target) {
    LUCERNA_ASSIGN_OR_RETURN(const bool done, rows_.step(*scene_, settings, stop));
    if (!done) {
      set_counts(response->mutable_cost(), work_);
      return absl::OkStatus();
    }
    const TileResult result = rows_.take();
    work_ += result.work;
    for (const std::uint32_t n : result.samples) samples_done_ += n;
    set_tile(*scene_, settings, 0, settings.block_count, result, response->mutable_tile());
  } else {
    if (!sending_) {
      LUCERNA_ASSIGN_OR_RETURN(const bool reached, add_blocks(stop));
      if (!reached) {
        set_counts(response->mutable_cost(), work_);
        return absl::OkStatus();
      }
    }
    const BlockMerger<>& merged = merged_[tile_];
    if (sending_ || !is_timed() || !final_only_) {
      TileResult total{.channels = merged.total()};
      if (settings.intervals) total.moments = moments_[tile_].total();
      set_tile(*scene_, settings, 0, merged.blocks(), total, response->mutable_tile());
    }
    // Nobody needs the tile any more.
    if (sending_ || (!is_timed() && pass_end_ == blocks_)) {
      merged_[tile_] = BlockMerger<>(0, 0);
      if (settings.intervals) moments_[tile_] = BlockMerger<LuminanceMoments>(0, 0);
    }
  }
  response->set_samples_done(samples_done_);
  response->set_samples_total(samples_total_);
  set_counts(response->mutable_cost(), work_);
  ++tile_;
  if (settings.target || sending_) return absl::OkStatus();
  if (!is_waited_for() && left_s() <= 0) {
    end();
  } else if (tile_ == tiles_.size()) {
    end_pass();
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> RenderImageHandler::add_blocks(const std::stop_token& stop) {
  TileSettings& settings = query_.settings;
  BlockMerger<>& merged = merged_[tile_];
  if (merged.blocks() >= pass_end_) return true;
  std::optional<StopAt> in_time;
  if (!is_waited_for())
    in_time.emplace(Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                       std::chrono::duration<double>(std::max(0.0, left_s()))),
                    stop);
  if (!rows_.has_begun()) {
    settings.first_block = merged.blocks();
    settings.block_count = std::min(aligned_run(settings.first_block, pass_end_),
                                    rows_.blocks_of_a_row(settings.rect.x1 - settings.rect.x0));
  }
  const absl::StatusOr<bool> done =
      rows_.step(*scene_, settings, in_time ? in_time->token() : stop);
  // When the time is over, the tile keeps its blocks.
  if (!done.ok() && in_time && !stop.stop_requested()) return true;
  if (!done.ok() || !*done) return done;
  TileResult result = rows_.take();
  work_ += result.work;
  samples_done_ += result.work.samples;
  if (!merged.add(settings.first_block, settings.block_count, std::move(result.channels)) ||
      (settings.intervals &&
       !moments_[tile_].add(settings.first_block, settings.block_count, std::move(result.moments))))
    return absl::InternalError("tiles do not follow each other");
  return merged.blocks() >= pass_end_;
}

void RenderImageHandler::end_pass() {
  const std::uint64_t more = next_pass();
  // Without memory for another pass, the picture is what it is.
  if (more == 0 || !count(pass_end_ + more).ok()) return end();
  tile_ = 0;
  pass_begin_ = pass_end_;
  pass_end_ += more;
  pass_start_ = Clock::now();
}

void RenderImageHandler::end() {
  // Send the tiles that were held back so far.
  sending_ = is_timed() && final_only_;
  tile_ = sending_ ? 0 : tiles_.size();
}

std::uint64_t RenderImageHandler::next_pass() const {
  const std::uint64_t doubled = std::min(pass_end_, blocks_ - pass_end_);
  if (!is_timed() || pass_end_ < kWaitedForBlocks) return doubled;
  const std::chrono::duration<double> took = Clock::now() - pass_start_;
  const double block_s = took.count() / static_cast<double>(pass_end_ - pass_begin_);
  const double fits = kPlannedShare * left_s() / std::max(block_s, 1e-9);
  return static_cast<std::uint64_t>(std::clamp(fits, 0.0, static_cast<double>(doubled)));
}

bool RenderImageHandler::is_waited_for() const {
  return !is_timed() || pass_begin_ < kWaitedForBlocks;
}

double RenderImageHandler::left_s() const {
  const std::chrono::duration<double> since = Clock::now() - *begin_;
  return std::min(*query_.rule.time_budget_s, kLongestBudgetS) - since.count();
}

}  // namespace lucerna::rpc
