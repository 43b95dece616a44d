// Batches of questions about the light that emitters send out, over plain arrays.  As in queries.h:
// all work runs in the caller's oneTBB arena and is a function of its arguments alone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>

#include "server/queries.h"

namespace lucerna {

struct LeQuery {
  PointArray points;
  std::span<const float> directions;     ///< three a ray, of any length but 0
  std::optional<std::uint32_t> light{};  ///< index: only this one
  double time_s = 0;
};

/// Arrays to be filled, of one entry (or three) a ray; all start as zeros.
struct LeAnswer {
  float* radiance_cd_m2;
  /// The light that shines along the ray, the first of several infinite ones; 0 where none does.
  std::uint64_t* light_ids;
  int* status;  ///< ItemResult
};

/// Radiance that arrives against each ray from the first surface that it meets or, where it meets
/// none, from the infinite lights.  A surface that the ray's start lies on, within the default
/// position error, is not met.  Surfaces hide lights behind them, whether or not `light` is set.
/// kOutOfRange where a sum does not fit a float.
WorkCounts le(const Scene& scene, const LeQuery& query, const LeAnswer& answer,
              std::stop_token stop);

}  // namespace lucerna
