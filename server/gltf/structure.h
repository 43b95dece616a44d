// Checks the JSON text of a glTF file before tinygltf reads it.
#pragma once

#include "server/gltf/view.h"

namespace lucerna::gltf {

/// Checks types, ranges and indices of the members that `parse_model` reads.  Checks that nodes
/// form trees.  Fails at the first fault, with its JSON pointer.
void check_structure(const View& root);

/// Fails if the version is not 2.x, or if the file requires an extension that is not modelled. Adds
/// a remark for each other extension that the file uses.
void check_extensions(const View& root);

}  // namespace lucerna::gltf
