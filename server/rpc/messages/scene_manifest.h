// The files of a scene that a request lists.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "lucerna/v1/scene.pb.h"
#include "proto/common/status_macros.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

/// INVALID_ARGUMENT unless it has the length of a SHA-256.
absl::Status check_digest(const std::string& field, const std::string& digest);

/// The name of a scene file under the scene root.  `field`: its name, for errors.
absl::Status check_path(const CallContext& context, const std::string& field,
                        const std::string& path);
/// A manifest of a request.
absl::StatusOr<Manifest> check_manifest(const CallContext& context, const std::string& field,
                                        const v1::SceneManifest& given);

/// The scene file of a message that has either `manifest` or `path`.  `prefix`: of the names of its
/// fields.
template <typename Message>
absl::StatusOr<SceneSource> check_scene_file(const CallContext& context, const std::string& prefix,
                                             const Message& message) {
  if (message.has_manifest())
    return check_manifest(context, prefix + "manifest", message.manifest());
  LUCERNA_RETURN_IF_ERROR(check_path(context, prefix + "path", message.path()));
  return message.path();
}

}  // namespace lucerna::rpc
