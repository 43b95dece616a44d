// Puts meshes into the scene.
#pragma once

#include "server/gltf/document.h"
#include "server/gltf/gltf_materials.h"
#include "server/gltf/tree.h"

namespace lucerna::gltf {

/// Adds the meshes of all nodes.  A mesh with one place becomes shapes.  A mesh with several
/// becomes an object with instances; only its emissive parts are copied to each place.
void place_meshes(const Document& document, Materials& materials, const Tree& tree);

}  // namespace lucerna::gltf
