// EXT_lights_image_based: the sky of a scene.
#pragma once

#include "server/gltf/document.h"
#include "server/gltf/tree.h"

namespace lucerna::gltf {

/// Reads the pictures of the largest level of each light, so that one answer lists all missing
/// files.
void read_environment_pictures(const Document& document);

/// Adds the light of the scene, if it has one.
///
/// The six faces of its first level become one latitude-longitude picture of about the same
/// resolution.  A texel is a radiance [cd/m2] per unit of intensity.  Four-channel PNG files hold
/// RGB divided by alpha.  The blurred levels and the irradiance coefficients are not used, because
/// the server computes both from the picture.
void add_environment(const Document& document, const Tree& tree);

}  // namespace lucerna::gltf
