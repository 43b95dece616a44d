// The edits of EditLights and LoadScene.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

using LightEditList = google::protobuf::RepeatedPtrField<v1::LightEdit>;

/// Checks what can be checked without the scene, so that bad requests cost nothing.
absl::Status check_edits(const CallContext& context, const LightEditList& edits);

/// The result of edits.
struct EditedScene {
  LoadedScene revision;
  std::vector<std::uint64_t> new_ids;  ///< of added and replaced lights
};
/// Applies edits to those that `scene` has, and stores the revision.  Reads the files of lights
/// that they add; if some are missing, only names them.  Requires check_edits().  Errors: a light
/// that the scene does not have; those of reading a file; those of SceneStore::revise.
absl::StatusOr<EditedScene> edited_scene(const CallContext& context, const StoredScene& scene,
                                         const LightEditList& edits, double lease_s,
                                         const std::stop_token& stop);

}  // namespace lucerna::rpc
