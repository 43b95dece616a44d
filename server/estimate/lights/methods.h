// The ways in which an estimate may be made, where there are several.
#pragma once

#include <cstdint>
#include <optional>

#include "lights/sampling/area_sampling.h"
#include "server/scene/light_selection.h"

namespace lucerna {

// lucerna/v1/accuracy.proto says what each means, at the enum of the same name.
enum class Sampler { kSobol, kIndependent };
enum class Combination { kPowerHeuristic, kBalanceHeuristic, kLights, kSurfaces };
enum class ClosedForms { kAutomatic, kOff, kEmptyShafts };
enum class VisibilityMethod { kRays, kShadowMaps };

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
