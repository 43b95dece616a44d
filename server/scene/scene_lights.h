// From what a description says of a light to the light itself, about the scene's origin.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "lights/models/light.h"
#include "server/description/scene_description.h"
#include "server/scene/light_selector.h"

namespace lucerna {

class Scene;

/// Where a light without a surface is.
LightPlace place_of(const LightDescription& light);

/// Errors: as the light's own.
absl::StatusOr<Light<double>> create_light(const LightDescription& light,
                                           const Vec3<double>& origin);

/// The area light of a shape that emits.  Rays hit its vertices rounded to floats; light comes from
/// where they are in double, so that small lamps far from zero keep their size.  Errors: as
/// the light's own; a shape that cannot emit.
absl::StatusOr<Light<double>> create_area_light(const ShapeDescription& shape,
                                                const Vec3<double>& origin);

/// How many primitives its surface has; 1 where it has none.
std::uint64_t primitive_count(const Light<double>& light);

/// All lights, or all but delta lights, as they are chosen from.
std::vector<LightSelector::Item> selector_items(const Scene& scene, bool areas_alone);

}  // namespace lucerna
