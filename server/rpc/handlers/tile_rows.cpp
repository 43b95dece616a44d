#include "server/rpc/handlers/tile_rows.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <iterator>
#include <utility>
#include <vector>

namespace lucerna::rpc {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kStepSeconds = 0.1;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// How many `units` fit into the time of a step, from 1 to `most`.
std::uint64_t fitting(double left_s, double unit_s, std::uint64_t most) {
  if (unit_s == 0) return 1;
  return static_cast<std::uint64_t>(std::clamp(left_s / unit_s, 1.0, static_cast<double>(most)));
}

/// `total`: the size at the end.
template <typename T>
void append_to(std::vector<T>& all, std::vector<T>&& more, std::uint64_t total) {
  if (more.empty()) return;
  if (more.size() == total) {
    all = std::move(more);
    return;
  }
  all.reserve(total);
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

absl::StatusOr<bool> TileRows::step(const Scene& scene, const TileSettings& settings,
                                    const std::stop_token& stop) {
  if (!std::exchange(has_begun_, true)) {
    tile_ = {};
    x_ = settings.rect.x0;
    y_ = settings.rect.y0;
  }
  const PixelRect& tile = settings.rect;
  const int width = tile.x1 - tile.x0;
  const auto blocks = static_cast<double>(settings.block_count);
  const Clock::time_point begin = Clock::now();
  for (double used_s = 0; y_ < tile.y1 && used_s < kStepSeconds;) {
    const auto left = static_cast<std::uint64_t>(tile.y1 - y_) * static_cast<std::uint64_t>(width);
    const auto pixels = static_cast<int>(fitting(kStepSeconds - used_s, blocks * unit_s_, left));
    // Whole rows, or a part of one.
    TileSettings part = settings;
    part.rect = x_ == tile.x0 && pixels >= width
                    ? PixelRect{tile.x0, y_, tile.x1, y_ + pixels / width}
                    : PixelRect{x_, y_, std::min(x_ + pixels, tile.x1), y_ + 1};
    TileResult result = lucerna::render_tile(scene, part, stop);
    if (result.stopped) {
      discard();
      return absl::CancelledError("stopped");
    }
    const double now_s = seconds_since(begin);
    unit_s_ =
        (now_s - used_s) / (blocks * (part.rect.x1 - part.rect.x0) * (part.rect.y1 - part.rect.y0));
    used_s = now_s;
    append(std::move(result),
           static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(tile.y1 - tile.y0));
    const bool end_of_row = part.rect.x1 == tile.x1;
    x_ = end_of_row ? tile.x0 : part.rect.x1;
    y_ = end_of_row ? part.rect.y1 : y_;
  }
  if (y_ < settings.rect.y1) return false;
  has_begun_ = false;
  return true;
}

std::uint64_t TileRows::blocks_of_a_row(int width) const {
  return std::bit_floor(fitting(kStepSeconds, unit_s_ * width, std::uint64_t{1} << 30));
}

void TileRows::append(TileResult&& part, std::uint64_t pixels) {
  append_to(tile_.channels, std::move(part.channels), 3 * pixels);
  append_to(tile_.samples, std::move(part.samples), pixels);
  append_to(tile_.intervals, std::move(part.intervals), pixels);
  append_to(tile_.moments, std::move(part.moments), pixels);
  tile_.work += part.work;
}

}  // namespace lucerna::rpc
