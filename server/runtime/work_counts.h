// Samples and rays of an answer.
#pragma once

#include <cstdint>

namespace lucerna {

struct WorkCounts {
  std::uint64_t samples = 0;
  std::uint64_t camera_rays = 0;
  std::uint64_t indirect_rays = 0;  ///< rays that find the next surface of a path
  std::uint64_t shadow_rays = 0;
  std::uint64_t map_lookups = 0;    ///< in shadow maps, instead of shadow rays
  std::uint64_t map_compared = 0;   ///< look-ups that were compared with a ray
  std::uint64_t map_disagreed = 0;  ///< compared look-ups that differed from the ray
  std::uint64_t through_panes = 0;  ///< shadow rays that passed thin panes straight on
  std::uint64_t by_chance = 0;      ///< lamps found by way of smooth or nearly smooth surfaces
  std::uint64_t cut_short = 0;      ///< lamps by way of as many mirrors as paths may have

  WorkCounts& operator+=(const WorkCounts& w) {
    samples += w.samples;
    camera_rays += w.camera_rays;
    indirect_rays += w.indirect_rays;
    shadow_rays += w.shadow_rays;
    map_lookups += w.map_lookups;
    map_compared += w.map_compared;
    map_disagreed += w.map_disagreed;
    through_panes += w.through_panes;
    by_chance += w.by_chance;
    cut_short += w.cut_short;
    return *this;
  }
};

}  // namespace lucerna
