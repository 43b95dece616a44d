#include "server/files/file_listing.h"

#include <algorithm>
#include <deque>
#include <filesystem>
#include <system_error>
#include <utility>

#include "server/files/printable.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;

bool is_under(const fs::path& path, const fs::path& root) {
  return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
}

/// A regular file, or a link to one that AssetReader follows.
bool is_file(const fs::directory_entry& entry, const fs::path& root) {
  std::error_code error;
  if (!entry.is_symlink(error)) return entry.is_regular_file(error);
  if (fs::read_symlink(entry.path(), error).is_absolute() || error) return false;
  const fs::path target = fs::canonical(entry.path(), error);
  return !error && is_under(target, root) && fs::is_regular_file(target, error);
}

bool ends_with_one_of(const std::string& name, const std::vector<std::string>& extensions) {
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const std::string& e) { return name.ends_with(e); });
}

}  // namespace

FileListing list_files(const std::string& root, const std::vector<std::string>& extensions,
                       const FileListingLimits& limits) {
  FileListing listing;
  std::error_code error;
  const fs::path top = fs::canonical(root, error);
  if (error) return listing;
  // Breadth first, so that a limit drops the deepest files.
  std::deque<std::pair<fs::path, int>> folders{{top, 1}};
  std::size_t entries = 0;
  for (; !folders.empty(); folders.pop_front()) {
    const auto [folder, depth] = folders.front();
    fs::directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
      if (++entries > limits.entries) {
        listing.incomplete = true;
        std::sort(listing.paths.begin(), listing.paths.end());
        return listing;
      }
      const std::string name = entry->path().filename().string();
      if (name.starts_with('.') || !is_utf8(name)) continue;
      std::error_code ignored;
      if (!entry->is_symlink(ignored) && entry->is_directory(ignored)) {
        if (depth < limits.depth) {
          folders.emplace_back(entry->path(), depth + 1);
        } else {
          listing.incomplete = true;
        }
      } else if (ends_with_one_of(name, extensions) && is_file(*entry, top)) {
        listing.paths.push_back(entry->path().lexically_relative(top).string());
      }
    }
  }
  std::sort(listing.paths.begin(), listing.paths.end());
  return listing;
}

}  // namespace lucerna
