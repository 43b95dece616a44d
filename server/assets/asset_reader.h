// The only way by which loaders open files: names are relative to one root, and nothing outside of
// it can be reached.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "server/assets/asset.h"
#include "server/assets/file_source.h"

namespace lucerna {

struct AssetReaderOptions {
  /// What all reads of one reader may amount to together, unpacked where they are compressed.
  std::uint64_t max_total_bytes = std::uint64_t{4} << 30;
  bool use_openat2 = true;  ///< as in DirectorySourceOptions
};

struct AssetContent {
  std::string name;  ///< relative to the root, without `.` and `..`
  std::string bytes;
};

/// Reads files of one source and keeps the digest of each.  Not thread-safe; one reader a load.
///
/// Errors say the name as it was given.  A name that leads outside gives INVALID_ARGUMENT, the same
/// whether a file is there or not; a file that is missing beneath the root gives NOT_FOUND.
class AssetReader {
 public:
  /// Of the directory `root`.
  static absl::StatusOr<AssetReader> open(const std::string& root,
                                          const AssetReaderOptions& options = {});
  explicit AssetReader(std::unique_ptr<FileSource> source, const AssetReaderOptions& options = {});

  /// `name` resolved in the directory of `relative_to`, which is itself a name relative to the root
  /// (empty: the root).  `..` is resolved on the names, before any link is followed.
  /// Errors besides the above: no regular file (INVALID_ARGUMENT), too much (RESOURCE_EXHAUSTED).
  absl::StatusOr<AssetContent> read(const std::string& name, const std::string& relative_to = "");

  /// As `read`, and unpacks what is gzip-compressed by its first two bytes.  [RFC1952]
  absl::StatusOr<AssetContent> read_unpacked(const std::string& name,
                                             const std::string& relative_to = "");

  /// Every file read so far, once each, in the order in which they were first read.
  const std::vector<Asset>& assets() const { return assets_; }

  /// The same files as they are now: names as given, digests and sizes anew.  Counts nothing
  /// towards the total.  Errors as `read`.
  absl::StatusOr<std::vector<Asset>> rehash(const std::vector<Asset>& assets);

 private:
  absl::StatusOr<std::string> resolve(const std::string& name,
                                      const std::string& relative_to) const;

  std::unique_ptr<FileSource> source_;
  std::uint64_t max_total_bytes_;
  std::uint64_t remaining_bytes_;
  std::vector<Asset> assets_;
  std::set<std::string> seen_;
};

}  // namespace lucerna
