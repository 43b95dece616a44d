#include "server/store/scene_file.h"

#include <absl/strings/match.h>

#include <utility>

#include "server/gltf/load.h"
#include "server/pbrt/load.h"

namespace lucerna {

const std::vector<std::string>& scene_file_extensions() {
  static const std::vector<std::string> kExtensions{".pbrt", ".pbrt.gz", ".gltf", ".glb"};
  return kExtensions;
}

absl::StatusOr<SceneDescription> load_scene_file(AssetReader& assets, const std::string& name,
                                                 std::stop_token stop, const LoadLimits& limits) {
  if (absl::EndsWithIgnoreCase(name, ".gltf") || absl::EndsWithIgnoreCase(name, ".glb"))
    return load_gltf(assets, name, std::move(stop), limits);
  return load_pbrt(assets, name, std::move(stop), limits);
}

}  // namespace lucerna
