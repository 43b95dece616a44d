// Loaders open files only through this reader.  Names are relative to one root, and no name reaches
// a file outside of it.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "server/files/asset.h"
#include "server/files/file_source.h"
#include "server/files/load_budget.h"

namespace lucerna {

struct AssetReaderOptions {
  /// The most bytes of all reads of one reader together.  Compressed files also count unpacked.
  std::uint64_t max_total_bytes = std::uint64_t{4} << 30;
  /// A compressed file may unpack to this many bytes, or to this many times its own size if that
  /// is more.  So a small file cannot become gigabytes.
  std::uint64_t max_unpacked_bytes = std::uint64_t{256} << 20;
  std::uint64_t max_unpacked_ratio = 64;
  std::stop_token stop{};        ///< ends reading and unpacking with CANCELLED
  bool use_openat2 = true;       ///< as in DirectorySource::open_root
  LoadBudget* budget = nullptr;  ///< counts the bytes of contents; null: no limit
};

struct AssetContent {
  std::string name;  ///< relative to the root, without `.` and `..`
  std::string bytes;
  LoadBudget::Share share{};  ///< of `bytes`
};

/// Reads files of one source and keeps the digest of each.  Not thread-safe: use one reader for
/// each load.
///
/// Messages have the name as given.  INVALID_ARGUMENT for a name that leads out of the root, even
/// if no file is there.  NOT_FOUND for a file that does not exist under the root.
class AssetReader {
 public:
  /// A reader of the directory `root`.
  static absl::StatusOr<AssetReader> open(const std::string& root,
                                          const AssetReaderOptions& options = {});
  explicit AssetReader(std::unique_ptr<FileSource> source, const AssetReaderOptions& options = {});

  /// Reads `name`, relative to the directory of the file `relative_to`.  `relative_to` is relative
  /// to the root; empty: the root itself.  `..` is resolved on the names, before any link is
  /// followed.
  /// More errors: not a regular file (INVALID_ARGUMENT), over max_total_bytes or the budget
  /// (RESOURCE_EXHAUSTED), CANCELLED.
  absl::StatusOr<AssetContent> read(const std::string& name, const std::string& relative_to = "");

  /// As `read`, but unpacks a file that begins with the two bytes of gzip.  It may have several
  /// members, which follow each other.  The digest is that of the compressed file.
  /// More errors: broken, incomplete or followed by other bytes (INVALID_ARGUMENT), over
  /// max_unpacked_bytes and max_unpacked_ratio (RESOURCE_EXHAUSTED).  [RFC1952]
  absl::StatusOr<AssetContent> read_unpacked(const std::string& name,
                                             const std::string& relative_to = "");

  /// Each file read so far once, in the order of the first reads.
  const std::vector<Asset>& assets() const { return assets_; }

  /// The same files with their present digests and sizes.  Does not count towards max_total_bytes.
  /// Errors as `read`.
  absl::StatusOr<std::vector<Asset>> rehash(const std::vector<Asset>& assets);

 private:
  absl::StatusOr<std::string> resolve(const std::string& name,
                                      const std::string& relative_to) const;

  std::unique_ptr<FileSource> source_;
  AssetReaderOptions options_;
  std::uint64_t remaining_bytes_;
  std::vector<Asset> assets_;
  std::set<std::string> seen_;
};

}  // namespace lucerna
