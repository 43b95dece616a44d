// Options of an AssetStore.  A separate file, so that programs can set them without the store's
// header.
#pragma once

#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace lucerna {

struct AssetStoreOptions {
  /// The directory of the files.  It is made if it does not exist, and its files stay for the next
  /// server.  Empty: a temporary directory that is deleted with the store.
  std::string directory{};
  std::uint64_t max_asset_bytes = std::uint64_t{4} << 30;
  /// The most bytes of all files together.  Least recently used files are deleted first.
  std::uint64_t budget_bytes = std::uint64_t{16} << 30;
  /// If a writer sends nothing for this time, another writer may take over its file.
  std::chrono::milliseconds patience{10'000};
  /// The parts of an upload that nobody continued for this time are deleted.
  std::chrono::seconds keep_parts{86400};
  /// Files that were used within this time are not deleted to make room in the quota of their
  /// owner. So the files of one scene do not replace each other.
  std::chrono::seconds keep_owned{600};
  /// An upload that sends nothing for this time is ended.
  std::chrono::seconds stall_time{60};
  /// Writes to a file, as write(2) does.  Tests have disks that are full.
  std::function<ssize_t(int, const void*, std::size_t)> write = &::write;
};

}  // namespace lucerna
