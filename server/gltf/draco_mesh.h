// Decodes Draco's meshes within the limits of a load.
#pragma once

#include <draco/mesh/mesh.h>

#include <memory>
#include <string_view>

#include "server/gltf/view.h"

namespace lucerna::gltf {

/// The mesh in `bytes`.  A few bytes may announce a mesh of any size, so its numbers of triangles,
/// points and attributes are compared with the limits before the decoder allocates them.
///
/// Throws a StatusError at `place`: INVALID_ARGUMENT if the bytes are no mesh, RESOURCE_EXHAUSTED
/// over the limit of primitives, over kMostUnpackedBytes, or if the budget refuses the decoder's
/// memory.
std::unique_ptr<draco::Mesh> decode_draco(const View& place, std::string_view bytes);

}  // namespace lucerna::gltf
