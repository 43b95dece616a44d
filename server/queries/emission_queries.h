// Batches of queries about the light that lights emit, over plain arrays.  As in queries.h, all
// work runs in the caller's oneTBB arena and depends only on the arguments.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>

#include "server/queries/queries.h"

namespace lucerna {

struct LeQuery {
  PointArray points;
  std::span<const float> directions;     ///< three for each ray, any length except 0
  std::optional<std::uint32_t> light{};  ///< index; set: only this light counts
  double time_s = 0;
  std::span<const double> wavelengths_nm{};
  ThinGlass thin_glass = ThinGlass::kPasses;
};

/// Arrays to fill, with one entry (or three) for each ray.  All start as zeros.
struct LeAnswer {
  float* radiance_cd_m2;
  /// The light that the ray meets, the first one of several infinite lights; 0 for none.
  std::uint64_t* light_ids;
  int* status;                         ///< ItemResult
  float* spectral_radiance = nullptr;  ///< one for each wavelength, ray by ray
};

/// Radiance that arrives from the direction of each ray: from the first surface that it meets or,
/// if it meets none, from the infinite lights.  The surface at the ray's start, within the default
/// position error, is ignored.  Surfaces hide lights behind them, even if `light` is set.
/// kOutOfRange if a sum, or its value at a wavelength, does not fit a float.
WorkCounts le(const Scene& scene, const LeQuery& query, const LeAnswer& answer,
              std::stop_token stop);

struct SampleLeQuery {
  std::uint32_t rays = 0;
  std::optional<std::uint32_t> light{};  ///< index; unset: chosen for each ray
  std::optional<SeedRange> seed{};       ///< set: `u` and `u_light` are not read
  std::span<const float> u{};  ///< four for each ray (position, direction), in [0, 1] or not finite
  std::span<const double> u_light{};  ///< one for each ray, in [0, 1); only if `light` is unset
  double time_s = 0;
  std::span<const double> wavelengths_nm{};
};

/// Arrays to fill, with one entry (or three) for each ray.  All start as zeros.
struct SampleLeAnswer {
  float* offsets_m;  ///< about the scene's origin
  float* directions;
  float* light_normals;
  float* value;
  float* pdf_position_per_m2;
  float* pdf_direction_per_sr;
  std::uint64_t* light_ids;         ///< if the light is chosen
  double* selection_probability;    ///< if the light is chosen
  int* status;                      ///< ItemResult
  float* spectral_value = nullptr;  ///< one for each wavelength, ray by ray
};

/// Samples rays that leave lights.  With a seed, ray i is point first_item + i of one
/// low-discrepancy sequence.  In a scene without lights every ray is kBlack, its light 0, its
/// selection probability 1.
WorkCounts sample_le(const Scene& scene, const SampleLeQuery& query, const SampleLeAnswer& answer,
                     std::stop_token stop);

/// The densities with which `sample_le` of light `light` chooses rays from `points` in
/// `directions`. `directions`: three for each ray, any length except 0.
void pdf_le(const Scene& scene, std::uint32_t light, const PointArray& points,
            std::span<const float> directions, double time_s, float* pdf_position_per_m2,
            float* pdf_direction_per_sr, int* status, std::stop_token stop);

}  // namespace lucerna
