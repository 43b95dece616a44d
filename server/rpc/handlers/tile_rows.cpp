#include "server/rpc/handlers/tile_rows.h"

#include <algorithm>
#include <bit>
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

template <typename T>
void append_to(std::vector<T>& all, std::vector<T>&& more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

absl::StatusOr<bool> TileRows::step(const Scene& scene, const TileSettings& settings,
                                    const std::stop_token& stop) {
  if (!std::exchange(has_begun_, true)) {
    tile_ = {};
    y_ = settings.rect.y0;
  }
  TileSettings rows = settings;
  const double row_units =
      static_cast<double>(rows.rect.x1 - rows.rect.x0) * static_cast<double>(settings.block_count);
  const Clock::time_point begin = Clock::now();
  for (double used_s = 0; y_ < settings.rect.y1 && used_s < kStepSeconds;) {
    rows.rect.y0 = y_;
    rows.rect.y1 =
        y_ + static_cast<int>(fitting(kStepSeconds - used_s, row_units * unit_s_,
                                      static_cast<std::uint64_t>(settings.rect.y1 - y_)));
    TileResult result = lucerna::render_tile(scene, rows, stop);
    if (result.stopped) {
      discard();
      return absl::CancelledError("stopped");
    }
    const double now_s = seconds_since(begin);
    unit_s_ = (now_s - used_s) / (row_units * (rows.rect.y1 - rows.rect.y0));
    used_s = now_s;
    append(std::move(result));
    y_ = rows.rect.y1;
  }
  if (y_ < settings.rect.y1) return false;
  has_begun_ = false;
  return true;
}

std::uint64_t TileRows::blocks_of_a_row(int width) const {
  return std::bit_floor(fitting(kStepSeconds, unit_s_ * width, std::uint64_t{1} << 30));
}

void TileRows::append(TileResult&& rows) {
  append_to(tile_.channels, std::move(rows.channels));
  append_to(tile_.samples, std::move(rows.samples));
  append_to(tile_.intervals, std::move(rows.intervals));
  append_to(tile_.moments, std::move(rows.moments));
  tile_.work += rows.work;
}

}  // namespace lucerna::rpc
