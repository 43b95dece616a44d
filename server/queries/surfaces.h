// The surfaces that the camera sees.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "server/queries/queries.h"

namespace lucerna {

struct SurfacesQuery {
  std::span<const float> places;  ///< x and y on the picture, interleaved [pixels]
  double time_s = 0;
  std::size_t size() const { return places.size() / 2; }
};

/// Arrays to fill, with one entry (or three) for each place.  All start as zeros.
struct SurfacesAnswer {
  float* offsets_m;          ///< about the scene's origin
  float* normals;            ///< geometric, unit, on the side of the camera
  std::uint8_t* found;       ///< bits: whether the ray meets a surface
  std::uint64_t* light_ids;  ///< of the light whose surface it is; 0 for none
  int* status;               ///< ItemResult
};

/// kInvalidInput for places that are not on the picture.
WorkCounts find_surfaces(const Scene& scene, const SurfacesQuery& query,
                         const SurfacesAnswer& answer, std::stop_token stop);

}  // namespace lucerna
