// What a scene was made from.
#pragma once

#include <absl/status/status.h>

#include <optional>
#include <string>
#include <vector>

#include "server/description/scene_contents.h"
#include "server/description/scene_description.h"
#include "server/scene/scene_part.h"

namespace lucerna {

struct SceneReport {
  CameraDescription camera;
  Film film;
  RenderHints hints;
  LevelFactors level_factors;  ///< applied to the levels that the scene file states
  SceneContents contents;
  std::vector<Remark> remarks;
  std::vector<Asset> assets;
  std::optional<ScenePart> motion;  ///< the memory of all motions
};

/// The id of a scene from these files: SHA-256 over their names and digests, in order, as 64
/// hexadecimal digits.  `halved`: pictures that are not kept whole, which change answers.  Factors
/// of 1 do not change the id.
std::string scene_id(const std::vector<Asset>& assets,
                     const std::vector<HalvedPicture>& halved = {},
                     const LevelFactors& factors = {});

/// Errors: media, materials and objects that the scene does not have.
absl::Status check_references(const SceneDescription& scene);

/// Adds a remark for each of these pictures of the scene.
void remark_on_halved_pictures(const std::vector<HalvedPicture>& halved, SceneDescription& scene);

}  // namespace lucerna
