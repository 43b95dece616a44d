// Tiles of a picture.  A pixel depends only on scene, settings, seed, pixel and block.  The number
// of threads and the division into tiles have no influence.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "proto/common/confidence.h"
#include "proto/common/luminance_moments.h"
#include "proto/common/tile_statistics.h"
#include "server/estimate/methods.h"
#include "server/estimate/pilots.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

struct PixelRect {
  int x0, y0, x1, y1;  ///< half-open, within the film
};

/// Moving objects are blurred over this time.
struct Shutter {
  double open_s, close_s;  ///< finite, close_s >= open_s
};

struct TileSettings {
  PixelRect rect{};
  std::uint64_t seed = 0;
  std::uint32_t samples_per_block = 1;  ///< a power of two
  std::uint64_t first_block = 0;        ///< a multiple of block_count
  std::uint64_t block_count = 1;        ///< a power of two
  /// Reflections after the surface that the camera sees.  0: direct light only.  Unset: until
  /// Russian roulette ends the path.
  std::optional<std::uint32_t> bounces{};
  std::optional<double> time_s{};    ///< unset: the whole time that the shutter is open
  std::optional<Shutter> shutter{};  ///< unset: as in the scene file
  Methods methods{};
  /// If set, each pixel takes its own `samples_per_block`, a power of two, as many as its luminance
  /// needs.  `first_block` must be 0.  The limit is max_samples / block_count, which must be 1 or
  /// more.
  std::optional<TargetError> target{};
  /// Without a target error: also return the moments that intervals need.
  bool intervals = false;
  /// The blocks are consecutive parts of one sequence for each pixel.  Their scatter is an upper
  /// estimate of the error.  Not with `intervals` or `target`.  Requires
  /// (first_block + block_count) samples_per_block <= kMostSamplesPerBlock.
  bool one_sequence = false;
};

struct TileResult {
  /// Three channels (R, G, B) for each pixel, rows from the top: radiance [cd/m2] times the
  /// film's scale.
  std::vector<BlockStatistics> channels{};
  /// With a target error, for each pixel: its number of samples, and an interval for its converged
  /// luminance with the requested confidence, in the unit of the channels.
  std::vector<std::uint32_t> samples{};
  std::vector<ConfidenceInterval> intervals{};
  /// With `intervals` and no target error, for each pixel.
  std::vector<LuminanceMoments> moments{};
  WorkCounts work{};
  bool stopped = false;  ///< `stop` was requested; the other members are incomplete
};

/// Renders a tile in the caller's oneTBB arena.  Polls `stop` every few hundred rays.
TileResult render_tile(const Scene& scene, const TileSettings& settings, std::stop_token stop);

}  // namespace lucerna
