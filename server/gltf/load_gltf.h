// Loads scenes in glTF 2.0.  [glTF2]
#pragma once

#include <absl/status/statusor.h>

#include <stop_token>
#include <string>

#include "server/description/scene_description.h"
#include "server/files/asset_reader.h"

namespace lucerna {

/// Reads the .gltf or .glb file `name`, relative to the root of `assets`, and all files that it
/// names.  World space is that of the file: right-handed, +y up, metres.  `remarks` lists the
/// contents that the server does not model; `assets` lists every file that was read.
///
/// Errors begin with the file and a JSON pointer, "room.gltf#/nodes/3", or with file:line:column
/// for invalid JSON.  INVALID_ARGUMENT for invalid content and for a required extension that is not
/// modelled, NOT_FOUND for a missing file, RESOURCE_EXHAUSTED above a limit, CANCELLED soon after a
/// stop request.  If the reader's source returns FAILED_PRECONDITION for a file that is still
/// missing, the loader opens the other files too.  So all missing files are found at once.
///
/// `factors` multiply the levels of all lights but luminaires, which have candela by themselves.
absl::StatusOr<SceneDescription> load_gltf(AssetReader& assets, const std::string& name,
                                           std::stop_token stop = {}, const LoadLimits& limits = {},
                                           const LevelFactors& factors = {});

}  // namespace lucerna
