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

using Box = std::pair<Vec3<double>, Vec3<double>>;  ///< lower and upper corner [m, world]

/// A point of a light or of its portal [m, world]: near it its coordinates are small.  Nothing for
/// lights that have directions alone.
std::optional<Vec3<double>> anchor_of(const LightDescription& light);

/// The least box about where a light stands or starts; nothing for distant and infinite ones.
std::optional<Box> box_of(const LightDescription& light);

/// The least box about its portal; nothing where there is none.
std::optional<Box> portal_box_of(const LightDescription& light);

/// Errors: as the light's own.
absl::StatusOr<Light<double>> create_light(const LightDescription& light,
                                           const Vec3<double>& origin);

/// The area light of a shape that emits.  Rays hit its vertices rounded to floats; light comes from
/// where they are in double, so that small lamps far from zero keep their size.  Errors: as
/// the light's own; a shape that cannot emit.
absl::StatusOr<Light<double>> create_area_light(const ShapeDescription& shape,
                                                const Vec3<double>& origin);

/// What its surface is made of; 1 where it has none.
std::uint64_t primitive_count(const Light<double>& light);

/// All lights, or all but delta lights, as they are chosen from.
std::vector<LightSelector::Item> selector_items(const Scene& scene, bool areas_alone);

/// The picture that a light uses, null where there is none.
const Image* picture_of(const Light<double>& light);

/// Memory beside the model itself, without the picture.
std::uint64_t light_bytes(const Light<double>& light);
/// Of these, what points or directions are drawn with by the light's picture.
std::uint64_t distribution_bytes(const Light<double>& light);

}  // namespace lucerna
