// Methods of an estimate that a query may choose.
#pragma once

#include <cstdint>
#include <optional>

#include "lights/sampling/area_sampling.h"
#include "server/scene/light_selector.h"

namespace lucerna {

// The enums of the same name in lucerna/v1/accuracy.proto explain the values.
enum class Sampler { kSobol, kIndependent };
enum class Combination { kPowerHeuristic, kBalanceHeuristic, kLights, kSurfaces };
enum class ClosedForms { kAutomatic, kOff, kEmptyShafts };
enum class VisibilityMethod { kRays, kShadowMaps };
enum class ThinGlass { kPasses, kBlocks };

struct Methods {
  AreaSampling area_sampling = AreaSampling::kAutomatic;
  LightSelection light_selection = LightSelection::kAutomatic;
  std::optional<std::uint32_t> samples_per_light{};  ///< unset: each light's own
  std::optional<double> far_light_radii{};           ///< unset: never
  Sampler sampler = Sampler::kSobol;
  Combination combination = Combination::kPowerHeuristic;
  ClosedForms closed_forms = ClosedForms::kAutomatic;
  VisibilityMethod visibility = VisibilityMethod::kRays;
  ThinGlass thin_glass = ThinGlass::kPasses;
};

}  // namespace lucerna
