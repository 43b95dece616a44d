// Lights and cameras at nodes.
#pragma once

#include "server/gltf/document.h"
#include "server/gltf/tree.h"

namespace lucerna::gltf {

/// Reads the files of EXT_lights_ies, so that one answer lists all missing files.
void read_photometric_files(const Document& document);

/// Adds the lights of a node: KHR_lights_punctual and EXT_lights_ies.
void add_lights(const Document& document, const PlacedNode& node);

/// The first camera of `nodes` becomes the camera; others get a remark.
void set_camera(const Document& document, const std::vector<PlacedNode>& nodes);

}  // namespace lucerna::gltf
