#include "server/rpc/handlers/load_scene_handler.h"

#include <fmt/core.h>

#include <optional>
#include <utility>

#include "proto/common/defaults.h"
#include "proto/common/status_macros.h"
#include "server/gltf/blender_levels.h"
#include "server/rpc/handlers/light_edits.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/convert.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/messages/scene_manifest.h"
#include "server/store/scene_file.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<gltf::BlenderLightingMode> check_mode(v1::BlenderLightingMode mode) {
  switch (mode) {
    case v1::BLENDER_LIGHTING_MODE_STANDARD:
      return gltf::BlenderLightingMode::kStandard;
    case v1::BLENDER_LIGHTING_MODE_UNITLESS:
      return gltf::BlenderLightingMode::kUnitless;
    case v1::BLENDER_LIGHTING_MODE_RAW:
      return gltf::BlenderLightingMode::kRaw;
    default:
      break;
  }
  return bad_field("blender.mode", static_cast<int>(mode),
                   "[1, {}], the numbers of BlenderLightingMode",
                   static_cast<int>(v1::BlenderLightingMode_MAX));
}

/// The factors for the scene file `name`.
absl::StatusOr<LevelFactors> check_blender(const v1::BlenderLevels& blender,
                                           const std::string& name) {
  LUCERNA_ASSIGN_OR_RETURN(const gltf::BlenderLightingMode mode, check_mode(blender.mode()));
  const double lumens_per_watt =
      blender.has_lumens_per_watt() ? blender.lumens_per_watt() : gltf::kBlenderLumensPerWatt;
  if (!(lumens_per_watt > 0 && lumens_per_watt <= kMostLumensPerWatt)) {
    return bad_field("blender.lumens_per_watt", lumens_per_watt, "(0, {}]", kMostLumensPerWatt);
  }
  if (!is_gltf_name(name)) {
    return bad_field(
        "blender", fmt::format("{} for \"{}\"", v1::BlenderLightingMode_Name(blender.mode()), name),
        "only for .gltf and .glb files");
  }
  return gltf::blender_level_factors(mode, lumens_per_watt);
}

}  // namespace

Prepared handle_load_scene(const CallContext& context, const v1::LoadSceneRequest& request,
                           v1::LoadSceneResponse* response) {
  if (request.has_lease_s()) LUCERNA_RETURN_IF_ERROR(check_lease(request.lease_s()));
  LUCERNA_ASSIGN_OR_RETURN(SceneSource source, check_scene_file(context, "", request));
  std::optional<LevelFactors> factors;
  if (request.has_blender()) {
    LUCERNA_ASSIGN_OR_RETURN(factors, check_blender(request.blender(), main_file(source)));
  }
  LUCERNA_RETURN_IF_ERROR(check_edits(context, request.edits()));
  Task task;
  task.bulk = true;
  task.kind = JobKind::kLoad;
  task.cost = response->mutable_cost();
  task.run = [context, &request, source = std::move(source), factors,
              response](const std::stop_token& stop) -> absl::Status {
    // The lease is that of the revision, if there are edits.
    const double lease_s = request.lease_s();
    const LoadOptions options{request.edits().empty() ? lease_s : 0, stop, factors, context.caller};
    absl::StatusOr<LoadedScene> loaded = context.scenes.load(source, options);
    if (!loaded.ok()) return load_error(loaded.status());
    if (!request.edits().empty() && loaded->stored.scene != nullptr) {
      LUCERNA_ASSIGN_OR_RETURN(EditedScene edited, edited_scene(context, loaded->stored,
                                                                request.edits(), lease_s, stop));
      loaded = std::move(edited.revision);
    }
    set_loaded(*loaded, response);
    if (loaded->stored.scene != nullptr)
      add_remarks(*loaded->stored.scene, response->mutable_remarks());
    return absl::OkStatus();
  };
  return task;
}

}  // namespace lucerna::rpc
