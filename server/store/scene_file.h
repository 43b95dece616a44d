// Chooses the loader of a scene file.
#pragma once

#include <absl/status/statusor.h>

#include <stop_token>
#include <string>
#include <vector>

#include "server/assets/asset_reader.h"
#include "server/description/scene_description.h"

namespace lucerna {

/// The endings of names of scene files: .pbrt, .gltf and .glb.
const std::vector<std::string>& scene_file_extensions();

/// Reads the scene file `name`.  Names that end with .gltf or .glb, in upper or lower case, are
/// glTF; all others are .pbrt.  Errors: those of load_pbrt and load_gltf.
absl::StatusOr<SceneDescription> load_scene_file(AssetReader& assets, const std::string& name,
                                                 std::stop_token stop, const LoadLimits& limits);

}  // namespace lucerna
