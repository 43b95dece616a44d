#include "server/gltf/blender_levels.h"

#include <numbers>

namespace lucerna::gltf {

LevelFactors blender_level_factors(BlenderLightingMode mode, double lumens_per_watt) {
  // The numbers of the file over those in W/sr and W/m2.
  double lamps = 1, suns = 1;
  switch (mode) {
    case BlenderLightingMode::kStandard:
      lamps = suns = kBlenderLumensPerWatt;
      break;
    case BlenderLightingMode::kUnitless:
      break;
    case BlenderLightingMode::kRaw:
      lamps = 4 * std::numbers::pi;
      break;
  }
  return {.lamps = lumens_per_watt / lamps,
          .suns = lumens_per_watt / suns,
          .emission = lumens_per_watt};
}

}  // namespace lucerna::gltf
