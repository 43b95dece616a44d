// Meshes: primitives to triangles.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/gltf/document.h"
#include "server/gltf/gltf_materials.h"
#include "server/gltf/matrix.h"

namespace lucerna::gltf {

/// The triangles of one primitive.  cross(p1 - p0, p2 - p0) points to the outside.
struct Part {
  TriangleMeshData mesh;
  Materials::Use use;
  std::string pointer;  ///< of the primitive
};

/// How a mesh is deformed at rest.
struct Deformation {
  std::vector<double> weights;  ///< of its morph targets; empty: those of the mesh
  /// For each joint of a skin, the matrix from the mesh to the world.  Empty: no skin.
  std::vector<Matrix> joints;
};

/// The parts of mesh `index`, in the coordinates of the mesh, or in the world if it has joints.
/// Points and lines are left out, with a remark.
std::vector<Part> make_parts(const Document& document, Materials& materials, std::size_t index,
                             const Deformation& deformation);

/// Moves a mesh to another frame.  Its outside stays its outside.
TriangleMeshData transformed(const LoadState& context, const std::string& pointer,
                             TriangleMeshData mesh, const Transform& transform);

}  // namespace lucerna::gltf
