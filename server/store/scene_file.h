// Chooses the loader of a scene file.
#pragma once

#include <absl/status/statusor.h>

#include <stop_token>
#include <string>
#include <vector>

#include "server/description/scene_description.h"
#include "server/files/asset_reader.h"

namespace lucerna {

/// The endings of names of scene files: .pbrt, .pbrt.gz, .gltf and .glb.
const std::vector<std::string>& scene_file_extensions();

/// Whether the file is glTF: its name ends with .gltf or .glb, in upper or lower case.
bool is_gltf_name(const std::string& name);

/// Reads the scene file `name`, which is glTF or else .pbrt.  `factors` have no effect on .pbrt
/// files.  Errors: those of load_pbrt and load_gltf.
absl::StatusOr<SceneDescription> load_scene_file(AssetReader& assets, const std::string& name,
                                                 std::stop_token stop, const LoadLimits& limits,
                                                 const LevelFactors& factors);

}  // namespace lucerna
