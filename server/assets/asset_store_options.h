// Options of an AssetStore.  A separate file, so that programs can set them without the store's
// header.
#pragma once

#include <chrono>
#include <cstdint>
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
};

}  // namespace lucerna
