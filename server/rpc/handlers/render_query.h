// What tiles and pictures are asked for and answered with in the same words.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>

#include "lucerna/v1/render.pb.h"
#include "server/estimate/paths/render.h"
#include "server/rpc/messages/stop_rule.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

struct RenderQuery {
  TileSettings settings;  ///< without rectangle; with a time budget without blocks
  StopRule rule;          ///< its target is that of the settings, too
  /// Of a block, with a time budget, where the request says.
  std::optional<std::uint32_t> samples_per_block{};
  std::uint32_t most_samples = 0;  ///< of a pixel, with a time budget: a power of two
};

/// `proposed`: samples where the request does not say.
absl::StatusOr<RenderQuery> check_render(const Context& context, const Scene& scene,
                                         const v1::RenderTileRequest& request,
                                         std::uint32_t proposed);
absl::StatusOr<RenderQuery> check_render(const Context& context, const Scene& scene,
                                         const v1::RenderImageRequest& request,
                                         std::uint32_t proposed);

/// Samples where the request does not say: what the scene file proposes, where it does and the
/// limit allows.
std::uint32_t proposed_samples(const Context& context, const Scene& scene);

/// With a time budget, at least: where blocks are as long as `samples_per_block`, a multiple of
/// that.  A power of two.
std::uint32_t least_samples(const RenderQuery& query);

std::uint64_t area(const PixelRect& rect);

/// A tile of blocks [first_block, first_block + blocks); what `result` holds of them, with the
/// planes that a target error adds.
void set_tile(const Scene& scene, const TileSettings& settings, std::uint64_t first_block,
              std::uint64_t blocks, const TileResult& result, v1::Tile* out);

}  // namespace lucerna::rpc
