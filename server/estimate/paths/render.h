// Direct light and paths, tiles and irradiance.  Every pixel and every point is a function of
// (scene, settings, seed, pixel or item, block) alone, whatever threads and tiles share the work.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "proto/common/tile_statistics.h"
#include "server/estimate/lights/methods.h"
#include "server/estimate/statistics/confidence.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

struct PixelRect {
  int x0, y0, x1, y1;  ///< half-open, within the film
};

/// What moves is blurred over the time between.
struct Shutter {
  double open_s, close_s;  ///< finite, the latter not before the former
};

struct TileSettings {
  PixelRect rect{};
  std::uint64_t seed = 0;
  std::uint32_t samples_per_block = 1;  ///< a power of two
  std::uint64_t first_block = 0;        ///< a multiple of block_count
  std::uint64_t block_count = 1;        ///< a power of two
  /// Reflections after the surface that the camera sees: 0 is direct light only; unset: until
  /// Russian roulette ends the path.
  std::optional<std::uint32_t> bounces{};
  std::optional<double> time_s{};    ///< unset: all the time that the shutter is open
  std::optional<Shutter> shutter{};  ///< unset: as the scene file says
  Methods methods{};
  /// Set: `samples_per_block` is each pixel's own, a power of two, as many as this takes of its
  /// luminance, and `first_block` is 0.  At most max_samples / block_count, which is 1 or more.
  std::optional<TargetError> target{};
};

struct TileResult {
  /// Three channels (R, G, B) a pixel, rows from the top; radiance [cd/m2] times the film's scale.
  std::vector<BlockStatistics> channels{};
  /// Of each pixel, with a target error: samples that it is made of, and what holds its converged
  /// luminance, in the unit of the channels, with the confidence that was asked for.
  std::vector<std::uint32_t> samples{};
  std::vector<Interval> intervals{};
  WorkCounts work{};
  bool stopped = false;  ///< `stop` was asked for; the rest is not to be used
};

/// Runs in the oneTBB arena of the caller.  `stop` is polled every few hundred rays.
TileResult render_tile(const Scene& scene, const TileSettings& settings, std::stop_token stop);

struct IrradiancePoint {
  Vec3<double> position;       ///< about the scene's origin [m]
  Vec3<float> position_error;  ///< [m]
  Vec3<float> normal;          ///< unit
};

/// The surface that it stands for.
inline SurfaceHit surface_at(const IrradiancePoint& point, double time_s) {
  SurfaceHit hit;
  hit.position = point.position;
  hit.position_error = point.position_error;
  hit.ns = point.normal;
  hit.ng = Vec3<double>(hit.ns);
  hit.time_s = time_s;
  return hit;
}

struct IrradianceSettings {
  std::uint64_t seed = 0;
  std::uint64_t first_item = 0;         ///< number of points[0] in the caller's set
  std::uint32_t samples_per_block = 1;  ///< at most 2^28
  std::uint32_t block_count = 1;        ///< independent replicates; 1: no standard error
  /// Set: `samples_per_block` is each point's own, as many as this takes, at most
  /// max_samples / block_count, which is 1 or more.  Intervals are of its `confidence`, else of
  /// kConfidence.
  std::optional<TargetError> target{};
  std::optional<std::uint32_t> bounces{};  ///< 0: direct light only; unset: all
  bool per_light = false;                  ///< direct light by light beside the total
  double time_s = 0;
  Methods methods{};
  /// Direct light at these wavelengths beside the total.  Requires bounces = 0, as surfaces have no
  /// spectra.
  std::span<const double> wavelengths_nm{};
};

struct IrradianceEstimate {
  Rgb<double> irradiance_lx;
  Rgb<double> standard_error_lx;  ///< of each channel; infinite where block_count is 1 and the
                                  ///< answer not exact
  double illuminance_error_lx{};  ///< standard error of the luminance, likewise
  /// Holds the converged illuminance with that confidence.
  Interval illuminance_lx;
  /// Upper bound on the illuminance where every sample was 0 but light may be missed, else 0.
  double zero_bound_lx = 0;
  bool exact = false;  ///< standard error 0 because nothing was sampled
};

/// What one point took.
struct PointCost {
  std::uint64_t samples = 0;  ///< that the estimate is made of; others only said how many to take
  std::uint64_t rays = 0;     ///< of all kinds, for all samples
  double time_s = 0;          ///< on one thread
};

struct IrradianceResult {
  std::vector<IrradianceEstimate> points;
  /// Direct light of light l at point p, [p * lights + l]; empty unless asked for.
  std::vector<IrradianceEstimate> per_light;
  std::vector<PointCost> costs;  ///< of each point
  /// At wavelength k, of point p: [p * wavelengths + k] [W/m2/nm].  Of the same samples as the
  /// total.
  std::vector<double> spectral;
  std::vector<double> spectral_error;  ///< standard errors; of one block 0
  WorkCounts work;
  bool stopped = false;
};

/// Irradiance on the side of `normal`.  Runs in the oneTBB arena of the caller.
IrradianceResult estimate_irradiance(const Scene& scene, std::span<const IrradiancePoint> points,
                                     const IrradianceSettings& settings, std::stop_token stop);

}  // namespace lucerna
