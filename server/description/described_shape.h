// Makes shapes from their descriptions.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <vector>

#include "lights/shapes/all_shapes.h"
#include "server/description/scene_description.h"

namespace lucerna {

/// The primitives of a mesh, relative to `origin`.
std::vector<Triangle> primitives_of(const TriangleMeshData& mesh, const Vec3& origin);
std::vector<BilinearPatch> primitives_of(const PatchMeshData& mesh, const Vec3& origin);

/// The shape relative to `origin`.  `with_uv`: a mesh with the (u, v) of its corners, for a
/// picture. Errors: those of the shape; a curve.
absl::StatusOr<std::shared_ptr<const Shape>> create_shape(const Geometry& geometry,
                                                          const Vec3& origin, bool with_uv);

}  // namespace lucerna
