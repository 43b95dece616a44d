#include "server/gltf/load_gltf.h"

#include <absl/status/status.h>

#include <new>
#include <utility>

#include "server/gltf/gltf_lights.h"
#include "server/gltf/gltf_place.h"
#include "server/gltf/image_based.h"

namespace lucerna {

absl::StatusOr<SceneDescription> load_gltf(AssetReader& assets, const std::string& name,
                                           std::stop_token stop, const LoadLimits& limits,
                                           const LevelFactors& factors) {
  SceneDescription scene;
  scene.textures = Textures(limits.texture_bytes);
  scene.level_factors = factors;
  try {
    gltf::LoadState context(assets, scene, std::move(stop), name, limits);
    const gltf::Document document(context);
    gltf::Materials materials(document);
    materials.read_pictures();
    gltf::read_photometric_files(document);
    gltf::read_environment_pictures(document);
    document.require_all_files();

    const gltf::Tree tree(document);
    gltf::place_meshes(document, materials, tree);
    for (const gltf::PlacedNode& node : tree.nodes()) gltf::add_lights(document, node);
    gltf::add_environment(document, tree);
    gltf::set_camera(document, tree.nodes());
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
