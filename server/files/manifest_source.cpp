#include "server/files/manifest_source.h"

#include <fmt/core.h>

#include <algorithm>

namespace lucerna {
namespace {

std::vector<std::string> digests(const Manifest& manifest) {
  std::vector<std::string> all;
  for (const auto& [name, digest] : manifest.assets) all.push_back(digest);
  return all;
}

}  // namespace

ManifestSource::ManifestSource(const Manifest& manifest, AssetStore& store,
                               std::vector<MissingAsset>& missing)
    : assets_(manifest.assets), store_(store), pins_(store, digests(manifest)), missing_(missing) {}

absl::StatusOr<OpenFile> ManifestSource::open(const std::string& path, const std::string& name) {
  const auto found = assets_.find(path);
  if (found == assets_.end()) {
    add_missing(path, "");
  } else if (found->second.empty()) {
    return absl::NotFoundError(fmt::format("file \"{}\" does not exist", name));
  } else {
    absl::StatusOr<OpenFile> file = store_.read(found->second);
    if (!absl::IsNotFound(file.status())) return file;
    add_missing(path, found->second);
  }
  return absl::FailedPreconditionError(fmt::format("file \"{}\" was not uploaded", name));
}

void ManifestSource::add_missing(const std::string& name, const std::string& digest) {
  const auto is_it = [&](const MissingAsset& m) { return m.name == name; };
  if (std::none_of(missing_.begin(), missing_.end(), is_it)) missing_.push_back({name, digest});
}

}  // namespace lucerna
