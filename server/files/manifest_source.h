// The files of an uploaded scene: a client's names for assets.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "server/files/asset_store.h"
#include "server/files/file_source.h"

namespace lucerna {

struct Manifest {
  std::string main;  ///< the scene file's name among `assets`
  /// Names relative to the scene's root, and the digests of the files, 32 bytes.  An empty digest:
  /// the client has no such file.
  std::map<std::string, std::string> assets;
};

/// A file that a scene needs and that was not uploaded yet.
struct MissingAsset {
  std::string name;
  std::string digest;  ///< empty if the manifest does not name the file
};

/// Adds to `missing` each file that a loader opened before its upload, once, in the order of
/// opening.  `missing` and `store` must outlive the source.
class ManifestSource final : public FileSource {
 public:
  ManifestSource(const Manifest& manifest, AssetStore& store, std::vector<MissingAsset>& missing);

  absl::StatusOr<OpenFile> open(const std::string& path, const std::string& name) override;

 private:
  void add_missing(const std::string& name, const std::string& digest);

  std::map<std::string, std::string> assets_;
  AssetStore& store_;
  AssetStore::Pins pins_;
  std::vector<MissingAsset>& missing_;
};

}  // namespace lucerna
