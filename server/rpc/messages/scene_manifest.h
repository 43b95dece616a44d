// The files of a scene that a request lists.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "lucerna/v1/scene.pb.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

/// INVALID_ARGUMENT unless it has the length of a SHA-256.
absl::Status check_digest(const std::string& field, const std::string& digest);

/// A manifest of a request.  `field`: its name, for errors.
absl::StatusOr<Manifest> check_manifest(const Context& context, const std::string& field,
                                        const v1::SceneManifest& given);

}  // namespace lucerna::rpc
