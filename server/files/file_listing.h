// The files of one kind under a directory.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace lucerna {

struct FileListingLimits {
  std::size_t entries = 65536;  ///< most directory entries to visit
  int depth = 16;               ///< levels of folders; files of the root are level 1
};

struct FileListing {
  std::vector<std::string> paths;  ///< relative to the root, in the order of their bytes
  bool incomplete = false;         ///< a limit ended the search
};

/// The regular files under `root` whose names end with one of `extensions` (such as ".pbrt").
///
/// Leaves out hidden files and folders, names that are not UTF-8, and folders that cannot be read.
/// Does not follow symbolic links to folders.  A symbolic link to a file counts if it is relative
/// and its target is under the root, since AssetReader opens such links.
FileListing list_files(const std::string& root, const std::vector<std::string>& extensions,
                       const FileListingLimits& limits = {});

}  // namespace lucerna
