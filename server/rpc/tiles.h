// RenderService without gRPC.
#pragma once

#include <optional>
#include <vector>

#include "lucerna/v1/render.pb.h"
#include "proto/tile_statistics.h"
#include "server/render.h"
#include "server/rpc/task.h"

namespace lucerna::rpc {

Prepared render_tile(const Context& context, const v1::RenderTileRequest& request,
                     v1::RenderTileResponse* response);

/// A whole picture, tile by tile.  Samples are taken in passes that end at 1, 2, 4, ... blocks and
/// at the last block (or only there); each pass visits all tiles, row by row.  Not thread-safe.
class ImageRender {
 public:
  static absl::StatusOr<ImageRender> create(const Context& context,
                                            const v1::RenderImageRequest& request);

  bool done() const { return tile_ == tiles_.size(); }
  /// Renders the next tile; requires that it is not done.  Runs in the caller's oneTBB arena.
  /// `cost` sums up the times of all tiles so far.
  absl::Status next(const std::stop_token& stop, v1::RenderImageResponse* response);

 private:
  ImageRender() = default;
  void end_pass();

  std::shared_ptr<const Scene> scene_;
  TileSettings settings_;
  std::vector<PixelRect> tiles_;
  std::vector<BlockMerger> merged_;  // one a tile
  std::uint64_t blocks_ = 0;         // to do, for each pixel
  std::uint64_t pass_begin_ = 0, pass_end_ = 0;
  std::size_t tile_ = 0;  // the next one
  std::uint64_t samples_done_ = 0;
  WorkCounts work_;
};

}  // namespace lucerna::rpc
