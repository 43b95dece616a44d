#include "server/store/scene_file.h"

#include <absl/strings/match.h>

#include <utility>

#include "server/gltf/load_gltf.h"
#include "server/pbrt/load_pbrt.h"

namespace lucerna {

const std::vector<std::string>& scene_file_extensions() {
  static const std::vector<std::string> kExtensions{".pbrt", ".pbrt.gz", ".gltf", ".glb"};
  return kExtensions;
}

bool is_gltf_name(const std::string& name) {
  return absl::EndsWithIgnoreCase(name, ".gltf") || absl::EndsWithIgnoreCase(name, ".glb");
}

absl::StatusOr<SceneDescription> load_scene_file(AssetReader& assets, const std::string& name,
                                                 std::stop_token stop, const LoadLimits& limits,
                                                 const LevelFactors& factors) {
  if (is_gltf_name(name)) return load_gltf(assets, name, std::move(stop), limits, factors);
  return load_pbrt(assets, name, std::move(stop), limits);
}

}  // namespace lucerna
