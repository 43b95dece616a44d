// Unpacks buffer views with EXT_meshopt_compression.
#pragma once

#include <string>
#include <string_view>

#include "server/gltf/view.h"

namespace lucerna::gltf {

/// The bytes of a buffer view with EXT_meshopt_compression.  `packed` is the extension.
std::string unpack_meshopt(const View& packed, std::string_view bytes);

}  // namespace lucerna::gltf
