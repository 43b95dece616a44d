// Loads a scene from files of this machine on a server that cannot read them.
//
//   const auto loaded = upload_scene(client, "scenes/room/scene.pbrt");
//   if (loaded.ok()) request.set_scene_id(loaded->scene_id());
//
// The client parses nothing.  The server reports which files are missing, and the client sends
// them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "lucerna/client/client.h"

namespace lucerna::client {

struct UploadProgress {
  std::string name;          ///< the name of the file in the scene
  std::uint64_t sent_bytes;  ///< bytes that the server has
  std::uint64_t size_bytes;
};

struct UploadOptions {
  /// Only files in this directory are sent, even if the server requests others.  The server knows
  /// files by their names relative to it.  Empty: the directory of the scene file.
  std::string root = {};
  /// The server keeps the scene for at least this time [s].  0: until it needs the memory.
  double lease_s = 0;
  /// The same as in LoadSceneRequest.
  std::optional<v1::BlenderLevels> blender = {};
  google::protobuf::RepeatedPtrField<v1::LightEdit> edits = {};
  /// Called after each sent chunk, in the calling thread.
  std::function<void(const UploadProgress&)> progress = {};
};

/// Loads the scene file `path` and all files that it names.  Sends only content that the server
/// does not have, and each content once.  An interrupted upload continues where it stopped.
///
/// Errors:
/// - NOT_FOUND if the scene file does not exist
/// - INVALID_ARGUMENT for a file outside the root, or one that changed during the upload
/// - errors of Client::load_scene and Client::upload_asset
/// - UNAVAILABLE after several attempts in a row without progress
absl::StatusOr<v1::LoadSceneResponse> upload_scene(const Client& client, const std::string& path,
                                                   const UploadOptions& upload = {},
                                                   const CallOptions& options = {});

}  // namespace lucerna::client
