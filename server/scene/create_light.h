// Makes lights from their descriptions, relative to the scene's origin.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>

#include "server/description/scene_description.h"
#include "server/scene/scene_light.h"

namespace lucerna {

/// Where a light without a surface is.
LightPlace place_of(const LightDescription& light);

/// Errors: those of the light.
absl::StatusOr<LightPointer> create_light(const LightDescription& light, const Vec3& origin);

/// The area light of an emissive shape.  Rays hit its vertices rounded to floats.  Light leaves
/// the vertices in double, so that small lamps far from zero keep their size.  Errors: those of
/// the light; a shape that cannot emit.
absl::StatusOr<LightPointer> create_area_light(const ShapeDescription& shape, const Vec3& origin);

/// The number of primitives of its surface; 1 if it has no surface.
std::uint64_t primitive_count(const Light& light);

/// Reference counts and the allocator's header of a light on the heap [bytes].
inline constexpr std::uint64_t kLightHeapBytes = 24;

}  // namespace lucerna
