// Scenes from this machine's files.  Nothing is parsed here: the server says which files it misses,
// and gets those.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "lucerna/client/client.h"

namespace lucerna::client {

struct UploadProgress {
  std::string name;          ///< as the scene calls the file
  std::uint64_t sent_bytes;  ///< of which the server has these
  std::uint64_t size_bytes;
};

struct UploadOptions {
  /// No file outside of this directory is ever sent, whatever the server asks for; names in the
  /// scene are relative to it where they do not begin at the scene file.  Empty: the scene file's.
  std::string root = {};
  /// How long the server is to keep the scene at least [s]; 0: until it needs the memory.
  double lease_s = 0;
  /// Called as bytes go, in the calling thread.
  std::function<void(const UploadProgress&)> progress = {};
};

/// Loads the scene file `path` and all that it names, on a server that need not see any of it.
/// Only what the server does not hold is sent, each content once; an upload that breaks goes on
/// where it broke.
///
/// Errors: NOT_FOUND for a scene file that is not there, INVALID_ARGUMENT for a file outside of the
/// root or one that changed while it was sent; those of Client::load_scene and
/// Client::upload_asset.  UNAVAILABLE after several tries in a row without progress.
absl::StatusOr<v1::LoadSceneResponse> upload_scene(const Client& client, const std::string& path,
                                                   const UploadOptions& upload = {},
                                                   const CallOptions& options = {});

}  // namespace lucerna::client
