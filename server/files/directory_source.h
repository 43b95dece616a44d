// Files under one directory.  No name reaches a file outside of it, whether by `..`, an absolute
// name or a symbolic link.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "server/files/file_source.h"

namespace lucerna {

class DirectorySource final : public FileSource {
 public:
  /// NOT_FOUND if `root` is not a directory that can be opened.
  ///
  /// `use_openat2` uses openat2 (Linux 5.6) if the kernel has it: the kernel then keeps paths under
  /// the root.  Without openat2, all symbolic links are refused.
  static absl::StatusOr<std::unique_ptr<DirectorySource>> open_root(const std::string& root,
                                                                    bool use_openat2);

  absl::StatusOr<OpenFile> open(const std::string& path, const std::string& name) override;

 private:
  DirectorySource(Descriptor root, bool use_openat2)
      : root_(std::move(root)), use_openat2_(use_openat2) {}

  Descriptor root_;
  bool use_openat2_;
};

/// INVALID_ARGUMENT for a name that leads out of a scene's files.
absl::Status leaves_root(const std::string& name);
/// INVALID_ARGUMENT for a file that exists and cannot be read.
absl::Status unreadable(const std::string& name);

}  // namespace lucerna
