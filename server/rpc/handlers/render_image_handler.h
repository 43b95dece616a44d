// RenderImage without gRPC.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "lucerna/v1/render.pb.h"
#include "proto/common/tile_statistics.h"
#include "server/estimate/render.h"
#include "server/rpc/handlers/render_query.h"
#include "server/rpc/handlers/tile_rows.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

/// A whole picture, tile by tile.  Samples are taken in passes that end at 1, 2, 4, ... blocks and
/// at the last block, or only there.  Each pass visits all tiles, row by row.  With a target error
/// there is one pass.  With a time budget, the first two passes run to their end.  Each further
/// pass is planned for the rest of the time, by the speed of the previous pass.  Tiles that it does
/// not reach in time keep their blocks.  Not thread-safe.
class RenderImageHandler {
 public:
  /// Its memory counts against the budget of scenes.  Errors: those of the request;
  /// RESOURCE_EXHAUSTED if the memory does not fit.
  static absl::StatusOr<RenderImageHandler> create(const CallContext& context,
                                                   const v1::RenderImageRequest& request);

  bool done() const { return tile_ == tiles_.size(); }
  /// Of the picture.
  std::uint64_t pixels() const;
  /// Renders the next tile, or some of its samples if all would take long.  Requires !done().  Runs
  /// in the caller's oneTBB arena.  The response's `cost` has the counts of all tiles so far.  The
  /// response has no tile if it is too early to send one.
  absl::Status next(const std::stop_token& stop, v1::RenderImageResponse* response);

 private:
  using Clock = std::chrono::steady_clock;

  RenderImageHandler() = default;
  /// Renders blocks of the tile for a short time.  True: the tile has reached the end of the pass,
  /// or the time is over.  False: the next step continues with this tile.
  absl::StatusOr<bool> add_blocks(const std::stop_token& stop);
  /// Counts the memory that is needed up to the end of this pass.
  absl::Status count(std::uint64_t pass_end);
  void end_pass();
  void end();
  /// The number of blocks of the next pass; 0: there is none.
  std::uint64_t next_pass() const;
  bool is_timed() const { return query_.rule.time_budget_s.has_value(); }
  /// Whether this pass runs to its end even if the time budget is over.
  bool is_waited_for() const;
  double left_s() const;

  std::shared_ptr<const Scene> scene_;
  RenderQuery query_;
  bool final_only_ = false;
  std::shared_ptr<LoadBudget> memory_;
  std::uint64_t counted_ = 0;  // in `memory_`
  std::vector<PixelRect> tiles_;
  std::vector<BlockMerger<>> merged_;                   // one for each tile
  std::vector<BlockMerger<LuminanceMoments>> moments_;  // with intervals, one for each tile
  TileRows rows_;                                       // of the tile that is rendered now
  std::uint64_t blocks_ = 0;  // of each pixel at the end; with a time budget, the most
  std::uint64_t pass_begin_ = 0, pass_end_ = 0;
  std::size_t tile_ = 0;  // the next one
  bool sending_ = false;  // everything is rendered, and tiles are only sent
  std::uint64_t samples_done_ = 0, samples_total_ = 0;
  WorkCounts work_;
  std::optional<Clock::time_point> begin_;
  Clock::time_point pass_start_;
};

}  // namespace lucerna::rpc
