// Loads scenes in pbrt-v4's file format.  [PbrtFormat]
#pragma once

#include <absl/status/statusor.h>

#include <stop_token>
#include <string>

#include "server/description/scene_description.h"
#include "server/files/asset_reader.h"

namespace lucerna {

/// Reads the scene file `name`, relative to the root of `assets`, and all files that it names.
/// `remarks` lists the contents that the server does not model; `assets` lists every file that was
/// read.
///
/// Errors begin with file:line:column: INVALID_ARGUMENT for invalid content (expected and found),
/// NOT_FOUND for a missing file, RESOURCE_EXHAUSTED above the reader's limit.  CANCELLED soon after
/// a stop request.  If the reader's source returns FAILED_PRECONDITION for a file that is still
/// missing, the rest of the scene is read too.  So all missing files are found at once.  Other
/// errors may then follow from the missing file.
absl::StatusOr<SceneDescription> load_pbrt(AssetReader& assets, const std::string& name,
                                           std::stop_token stop = {},
                                           const LoadLimits& limits = {});

}  // namespace lucerna
