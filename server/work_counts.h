// What was spent on an answer.
#pragma once

#include <cstdint>

namespace lucerna {

struct WorkCounts {
  std::uint64_t samples = 0;
  std::uint64_t camera_rays = 0;
  std::uint64_t indirect_rays = 0;  ///< rays that look for the next surface of a path
  std::uint64_t shadow_rays = 0;

  WorkCounts& operator+=(const WorkCounts& w) {
    samples += w.samples;
    camera_rays += w.camera_rays;
    indirect_rays += w.indirect_rays;
    shadow_rays += w.shadow_rays;
    return *this;
  }
};

}  // namespace lucerna
