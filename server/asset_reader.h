// The only way by which loaders open files: names are relative to one root directory, and nothing
// outside of it can be reached, by `..`, by an absolute name or through a symbolic link.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "server/scene_description.h"

namespace lucerna {

struct AssetReaderOptions {
  /// What all reads of one reader may amount to together, unpacked where they are compressed.
  std::uint64_t max_total_bytes = std::uint64_t{4} << 30;
  /// Let the kernel keep path resolution beneath the root (openat2, Linux 5.6), where it can.
  /// Without it symbolic links are refused altogether.
  bool use_openat2 = true;
};

struct AssetContent {
  std::string name;  ///< relative to the root, without `.` and `..`
  std::string bytes;
};

/// Reads files beneath a root and keeps the digest of each.  Not thread-safe; one reader a load.
///
/// Errors say the name as it was given.  A name that leads outside gives INVALID_ARGUMENT, the same
/// whether a file is there or not; a file that is missing beneath the root gives NOT_FOUND.
class AssetReader {
 public:
  static absl::StatusOr<AssetReader> open(const std::string& root,
                                          const AssetReaderOptions& options = {});

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
  absl::StatusOr<std::vector<Asset>> rehash(const std::vector<Asset>& assets) const;

 private:
  /// A file descriptor that closes itself.
  class Descriptor {
   public:
    explicit Descriptor(int fd) : fd_(fd) {}
    Descriptor(Descriptor&& other) noexcept;
    Descriptor& operator=(Descriptor&& other) noexcept;
    ~Descriptor();
    int get() const { return fd_; }

   private:
    int fd_;
  };
  struct OpenFile;

  AssetReader(Descriptor root, const AssetReaderOptions& options);
  absl::StatusOr<OpenFile> open_beneath(const std::string& name, const std::string& path) const;
  absl::StatusOr<std::string> resolve(const std::string& name,
                                      const std::string& relative_to) const;

  Descriptor root_;
  AssetReaderOptions options_;
  std::uint64_t remaining_bytes_;
  std::vector<Asset> assets_;
  std::set<std::string> seen_;
};

}  // namespace lucerna
