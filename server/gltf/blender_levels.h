// The light levels that Blender's glTF exporter writes, in photometric units.
#pragma once

#include <cstdint>

#include "server/description/scene_description.h"

namespace lucerna::gltf {

/// The most light that a watt of light can have [lm/W]: that of 555 nm.  The exporter's constant.
inline constexpr double kBlenderLumensPerWatt = 683;

/// The exporter's setting Lighting Mode.
enum class BlenderLightingMode : std::uint8_t { kStandard, kUnitless, kRaw };

/// The factors for cd, lx and cd/m2.  `lumens_per_watt`: what Blender's watts mean, in (0, 1e6].
///
/// The exporter (v3.4.50) writes for a lamp of P watts 683 P / (4 pi), P / (4 pi) or P; for a sun
/// of S W/m2 683 S, S or S; for emission S in all modes.
LevelFactors blender_level_factors(BlenderLightingMode mode,
                                   double lumens_per_watt = kBlenderLumensPerWatt);

}  // namespace lucerna::gltf
