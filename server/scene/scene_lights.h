// Makes lights, about the scene's origin, from their descriptions.
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

using Box = std::pair<Vec3<double>, Vec3<double>>;  ///< lower and upper corner [m, world]

/// A point of a light or of its portal [m, world], near which its coordinates are small.
/// Nothing for lights that only have directions.
std::optional<Vec3<double>> anchor_of(const LightDescription& light);

/// The smallest box around the light's positions; nothing for distant and infinite lights.
std::optional<Box> box_of(const LightDescription& light);

/// The smallest box around the light's portal; nothing without a portal.
std::optional<Box> portal_box_of(const LightDescription& light);

/// Errors: those of the light.
absl::StatusOr<Light<double>> create_light(const LightDescription& light,
                                           const Vec3<double>& origin);

/// The area light of an emissive shape.  Rays hit its vertices rounded to floats.  Light leaves
/// the vertices in double, so that small lamps far from zero keep their size.  Errors: those of
/// the light; a shape that cannot emit.
absl::StatusOr<Light<double>> create_area_light(const ShapeDescription& shape,
                                                const Vec3<double>& origin);

/// The number of primitives of its surface; 1 without a surface.
std::uint64_t primitive_count(const Light<double>& light);

/// All lights, or all except delta lights, as items of a selector.
std::vector<LightSelector::Item> selector_items(const Scene& scene, bool areas_alone);

/// The picture of a light; null without one.
const Image* picture_of(const Light<double>& light);

/// Memory outside of the model's object, without the picture.
std::uint64_t light_bytes(const Light<double>& light);
/// The part of it that samples points or directions from the light's picture.
std::uint64_t distribution_bytes(const Light<double>& light);

}  // namespace lucerna
