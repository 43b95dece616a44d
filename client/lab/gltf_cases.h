// The cases that glTF can describe: point, spot and directional lights, and emissive meshes.
#pragma once

#include <vector>

#include "client/lab/conformance_cases.h"

namespace lucerna::conformance {

std::vector<Case> gltf_cases();

}  // namespace lucerna::conformance
