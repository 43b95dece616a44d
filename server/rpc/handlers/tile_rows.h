// Renders a tile in short steps, so that other calls can run between two steps.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <stop_token>
#include <utility>

#include "server/estimate/render.h"

namespace lucerna::rpc {

/// The bits of a pixel do not depend on the steps.  Not thread-safe.
class TileRows {
 public:
  /// Renders pixels of the tile `settings.rect`, row by row, for about 0.1 s, or one pixel.  True:
  /// all are done, and `take` has the tile.  Until then, each further call must have equal
  /// settings. CANCELLED if `stop` was requested; the pixels done so far are then lost.
  absl::StatusOr<bool> step(const Scene& scene, const TileSettings& settings,
                            const std::stop_token& stop);
  /// Whether a tile has begun and is not complete.
  bool has_begun() const { return has_begun_; }
  /// Forgets the pixels done so far.
  void discard() { has_begun_ = false; }
  TileResult take() { return std::move(tile_); }

  /// The most blocks of which a step renders a row of this width; a power of two.
  std::uint64_t blocks_of_a_row(int width) const;

 private:
  /// `pixels`: of the whole tile.
  void append(TileResult&& part, std::uint64_t pixels);

  bool has_begun_ = false;
  int x_ = 0, y_ = 0;  // the next pixel
  TileResult tile_;    // the pixels before it
  double unit_s_ = 0;  // wall time of one block of one pixel in the last step; 0: not known
};

}  // namespace lucerna::rpc
