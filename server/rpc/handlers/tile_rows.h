// Renders a tile in short steps, each of some rows, so that other calls can run between two steps.
#pragma once

#include <absl/status/statusor.h>

#include <chrono>
#include <cstdint>
#include <stop_token>

#include "server/estimate/paths/render.h"

namespace lucerna::rpc {

/// The bits of a pixel do not depend on the division into rows.  Not thread-safe.
class TileRows {
 public:
  /// Renders rows of the tile `settings.rect` for about 0.1 s, or one row.  True: all rows are
  /// done, and `take` has the tile.  Until then, each further call must have equal settings.
  /// CANCELLED if `stop` was requested; the rows done so far are then lost.
  absl::StatusOr<bool> step(const Scene& scene, const TileSettings& settings,
                            const std::stop_token& stop);
  /// Whether some rows are done.
  bool has_begun() const { return has_begun_; }
  /// Forgets the rows done so far.
  void discard() { has_begun_ = false; }
  TileResult take() { return std::move(tile_); }

  /// The most blocks of which a step renders a row of this width; a power of two.
  std::uint64_t blocks_of_a_row(int width) const;

 private:
  void append(TileResult&& rows);

  bool has_begun_ = false;
  int y_ = 0;          // the next row
  TileResult tile_;    // rows before y_
  double unit_s_ = 0;  // wall time of one block of one pixel in the last step; 0: not known
};

}  // namespace lucerna::rpc
