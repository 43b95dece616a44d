// The ways in which an estimate may be made, where there are several.
#pragma once

#include <cstdint>
#include <optional>

#include "lights/area_sampling.h"

namespace lucerna {

/// Which light a sample is spent on; their meaning is told at the enum of the same name in
/// lucerna/v1/accuracy.proto, as is that of the others here.
enum class LightSelection { kAutomatic, kAll, kUniform, kPower, kBvh };
enum class Sampler { kSobol, kIndependent };
enum class Combination { kPowerHeuristic, kBalanceHeuristic, kLights, kSurfaces };
enum class ClosedForms { kAutomatic, kOff, kEmptyShafts };
enum class VisibilityMethod { kRays, kShadowMaps };

/// Points of one light that one sample may ask for.
inline constexpr std::uint32_t kMostSamplesPerLight = 1024;

struct Methods {
  AreaSampling area_sampling = AreaSampling::kAutomatic;
  LightSelection light_selection = LightSelection::kAutomatic;
  std::optional<std::uint32_t> samples_per_light{};  ///< unset: each light's own
  std::optional<double> far_light_radii{};           ///< unset: never
  Sampler sampler = Sampler::kSobol;
  Combination combination = Combination::kPowerHeuristic;
  ClosedForms closed_forms = ClosedForms::kAutomatic;
  VisibilityMethod visibility = VisibilityMethod::kRays;
};

}  // namespace lucerna
