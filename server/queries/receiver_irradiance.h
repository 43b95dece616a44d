// Irradiance at points.  The answer for a point depends only on scene, settings, seed and item
// number.  The number of threads and the other points have no influence.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "proto/common/confidence.h"
#include "server/estimate/methods.h"
#include "server/estimate/missed_light.h"
#include "server/estimate/pilots.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

struct IrradiancePoint {
  Vec3 position;         ///< about the scene's origin [m]
  Vec3f position_error;  ///< [m]
  Vec3 normal;           ///< unit
};

/// The surface that the point represents.
inline SurfaceHit surface_at(const IrradiancePoint& point, double time_s) {
  SurfaceHit hit;
  hit.position = point.position;
  hit.position_error = point.position_error;
  hit.ns = point.normal;
  hit.ng = point.normal;
  hit.time_s = time_s;
  return hit;
}

struct IrradianceSettings {
  std::uint64_t seed = 0;
  std::uint64_t first_item = 0;  ///< number of the caller's first point
  /// Numbers of the points, counted from first_item; empty: 0, 1, 2, ...
  std::span<const std::uint32_t> numbers{};
  std::uint32_t samples_per_block = 1;  ///< at most 2^28
  std::uint32_t block_count = 1;        ///< independent blocks; 1: no standard error
  /// If set, each point takes its own `samples_per_block`, as many as the target needs. The limit
  /// is max_samples / block_count, which must be 1 or more.  Intervals have the target's
  /// `confidence`, else kConfidence.
  std::optional<TargetError> target{};
  std::optional<std::uint32_t> bounces{};  ///< 0: direct light only; unset: all
  bool per_light = false;                  ///< also the direct light of each light
  double time_s = 0;
  Methods methods{};
  /// Also direct light at these wavelengths.  Requires bounces = 0, because surfaces have no
  /// spectra.
  std::span<const double> wavelengths_nm{};
};

struct IrradianceEstimate {
  Rgb irradiance_lx;
  /// Standard error of the luminance; infinite where block_count is 1 and the answer not exact.
  double illuminance_error_lx{};
  /// Interval for the converged illuminance, with the confidence of the settings.
  ConfidenceInterval illuminance_lx;
  /// Upper bound of the illuminance if every sample was 0 but light may have been missed, else 0.
  double zero_bound_lx = 0;
  bool exact = false;    ///< standard error 0 because nothing was sampled
  MissedLight missed{};  ///< `illuminance_lx` includes its bound
};

/// The cost of one point.
struct PointCost {
  std::uint64_t samples = 0;  ///< samples of the estimate, without pilots
  std::uint64_t rays = 0;     ///< of all kinds, pilots included
  double time_s = 0;          ///< on one thread
};

struct IrradianceResult {
  std::vector<IrradianceEstimate> points;
  /// Direct light of light l at point p: [p * lights + l].  Empty without `per_light`.
  std::vector<IrradianceEstimate> per_light;
  std::vector<PointCost> costs;  ///< of each point
  /// At wavelength k of point p: [p * wavelengths + k] [W/m2/nm].  Uses the samples of the total.
  std::vector<double> spectral;
  std::vector<double> spectral_error;  ///< standard errors; 0 with one block
  WorkCounts work;
  bool stopped = false;
};

/// Irradiance on the side of `normal`.  Runs in the caller's oneTBB arena.
IrradianceResult estimate_irradiance(const Scene& scene, std::span<const IrradiancePoint> points,
                                     const IrradianceSettings& settings, std::stop_token stop);

}  // namespace lucerna
