// The edits of EditLights and LoadScene.
#pragma once

#include <memory>
#include <stop_token>
#include <vector>

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

using LightEditList = google::protobuf::RepeatedPtrField<v1::LightEdit>;

/// The result of edits.
struct EditedLights {
  LightEdits edits;                    ///< all of the scene's, not only the new ones
  std::vector<std::uint64_t> new_ids;  ///< of added and replaced lights
  std::vector<MissingAsset> missing;   ///< of added files; if any, `edits` is incomplete
  std::shared_ptr<SceneStore::LoadMemory> memory;  ///< of added files
};

/// Checks what can be checked without the scene, so that bad requests cost nothing.
absl::Status check_edits(const CallContext& context, const LightEditList& edits);

/// Applies edits to those that `scene` has.  Reads the files of lights that they add.  Requires
/// check_edits().  Errors: a light that the scene does not have; those of reading a file.
absl::StatusOr<EditedLights> edited_lights(const CallContext& context, const Scene& scene,
                                           const LightEditList& edits, const std::stop_token& stop);

}  // namespace lucerna::rpc
