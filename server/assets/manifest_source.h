// The files of a scene that was uploaded: names that a client gave to assets.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "server/assets/asset_store.h"
#include "server/assets/file_source.h"

namespace lucerna {

struct Manifest {
  std::string main;  ///< the scene file's name among `assets`
  /// Names relative to the scene's root and the digests of what they name, 32 bytes; empty for what
  /// the client was asked for and does not have.
  std::map<std::string, std::string> assets;
};

/// A file that a scene needs and that cannot be read yet.
struct MissingAsset {
  std::string name;
  std::string digest;  ///< empty where the manifest does not name the file
};

/// `missing` gets each file that was asked for and is not there yet, once, in the order of asking;
/// it must outlive the source, as `store` must.
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
