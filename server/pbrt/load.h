// Scenes in pbrt-v4's file format.  [PbrtFormat]
#pragma once

#include <absl/status/statusor.h>

#include <stop_token>
#include <string>

#include "server/assets/asset_reader.h"
#include "server/description/scene_description.h"

namespace lucerna {

/// Reads the scene file `name`, relative to the root of `assets`, and all files that it names. What
/// it asks for and is not modelled is in `remarks`; every file that was read is in `assets`.
///
/// Errors begin with file:line:column: INVALID_ARGUMENT for what a file may not say (what was
/// expected and what was found), NOT_FOUND for a missing file, RESOURCE_EXHAUSTED beyond the
/// reader's limit. CANCELLED soon after `stop` asks for it.  Where the reader's source says of a
/// file that it is not there yet (FAILED_PRECONDITION), what the rest of the scene names is asked
/// for too before the load fails; other errors may then be but a consequence.
absl::StatusOr<SceneDescription> load_pbrt(AssetReader& assets, const std::string& name,
                                           std::stop_token stop = {});

}  // namespace lucerna
