// Options of an AssetStore, apart from it: programs set them without reading how files are kept.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace lucerna {

struct AssetStoreOptions {
  /// Where the files are.  Made if it does not exist; the next server finds its files again.
  /// Empty: a temporary directory that is deleted with the store.
  std::string directory{};
  std::uint64_t max_asset_bytes = std::uint64_t{4} << 30;
  /// Of all files together.  Least recently used files are deleted first.
  std::uint64_t budget_bytes = std::uint64_t{16} << 30;
  /// A writer that has sent nothing for so long gives way to another writer of the same file.
  std::chrono::milliseconds patience{10'000};
};

}  // namespace lucerna
