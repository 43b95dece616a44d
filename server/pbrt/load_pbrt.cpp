#include "server/pbrt/load_pbrt.h"

#include <absl/status/status.h>

#include <new>
#include <utility>

#include "server/pbrt/parse_pbrt.h"

namespace lucerna {

absl::StatusOr<SceneDescription> load_pbrt(AssetReader& assets, const std::string& name,
                                           std::stop_token stop, const LoadLimits& limits) {
  SceneDescription scene;
  scene.textures = Textures(limits.texture_bytes);
  try {
    pbrt::LoadState context(assets, scene, std::move(stop), name, limits);
    pbrt::Builder builder(context);
    pbrt::Parser(context, builder).parse();
    context.finish_remarks();
  } catch (const StatusError& failure) {
    return failure.status();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("not enough memory to load the scene");
  }
  scene.assets = assets.assets();
  return scene;
}

}  // namespace lucerna
