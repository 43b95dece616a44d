// Code that RenderTile and RenderImage share.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>

#include "lucerna/v1/render.pb.h"
#include "server/estimate/render.h"
#include "server/rpc/messages/requested_accuracy.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

struct RenderQuery {
  TileSettings settings;  ///< without the rectangle; with a time budget, also without the blocks
  StopRule rule;          ///< its target is in the settings too
  /// With a time budget: as in the request.
  std::optional<std::uint32_t> samples_per_block{};
  std::uint32_t most_samples = 0;  ///< of a pixel, with a time budget; a power of two
};

/// Of RenderTile or RenderImage.  `proposed`: the default number of samples.  INVALID_ARGUMENT for
/// a field out of range.
template <typename Request>
absl::StatusOr<RenderQuery> check_render(const CallContext& context, const Scene& scene,
                                         const Request& request, std::uint32_t proposed);

/// The default number of samples: that of the scene file, else 64; at most the server's limit.
std::uint32_t proposed_samples(const CallContext& context, const Scene& scene);

/// The least number of samples with a time budget: a power of two, and a multiple of
/// `samples_per_block` if that is set.
std::uint32_t least_samples(const RenderQuery& query);

std::uint64_t area(const PixelRect& rect);

/// The memory of the statistics of a pixel, and nearly that of a pixel in a message.
std::uint64_t pixel_bytes(const TileSettings& settings);

/// Encodes the tile of blocks [first_block, first_block + blocks) with the statistics of `result`,
/// and with the planes of a target error if it has them.
void set_tile(const Scene& scene, const TileSettings& settings, std::uint64_t first_block,
              std::uint64_t blocks, const TileResult& result, v1::Tile* out);

}  // namespace lucerna::rpc
