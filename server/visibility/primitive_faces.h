// The primitives of a geometry set as faces of mirrors and glass.
#pragma once

#include <cstdint>
#include <optional>

#include "server/rays/accelerator.h"
#include "server/rays/surface_table.h"
#include "server/visibility/face_plane.h"

namespace lucerna {

/// The corners of a primitive, in the space of the set [m].  Empty if it is curved.
Face face_of(const GeometrySet& set, HitKind kind, std::uint32_t i);
/// The normal of a primitive that is flat, on its outside, in the space of the set.  Not finite, or
/// zero, if it has no area.
Vec3 face_normal(const GeometrySet& set, HitKind kind, std::uint32_t i);
/// Whether shading normals turn light away from the mirror direction of the face.
bool has_other_normals(const GeometrySet& set, const SurfaceTable& table, HitKind kind,
                       std::uint32_t i);
/// A mirror ball, in the scene [m]; nothing if a part of the sphere is missing or it is no ball
/// there.  `placed`: the instance, or null.
std::optional<FacePlane> whole_sphere(const Sphere& sphere, const GeometryInstance* placed,
                                      SmoothPart part);
/// Adds a box of the primitives, in the scene [m].
void add_bounds(const GeometrySet& set, const GeometryInstance* placed, const PrimitiveRange& run,
                Bounds& to);

}  // namespace lucerna
