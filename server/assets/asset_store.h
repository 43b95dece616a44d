// Uploaded files, kept on disk by the SHA-256 of their content, so that what many scenes and many
// clients send is there once.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/common/sha256.h"
#include "server/assets/asset_store_options.h"
#include "server/assets/file_source.h"

namespace lucerna {

class AssetStore;

/// One file on its way in.  What arrived stays for a later upload to go on from where this one is
/// destroyed before its end.
class AssetUpload {
 public:
  AssetUpload(AssetUpload&& other) noexcept
      : store_(std::exchange(other.store_, nullptr)),
        digest_(std::move(other.digest_)),
        size_(other.size_),
        writer_(other.writer_),
        bytes_(other.bytes_),
        file_(std::move(other.file_)),
        sha_(std::move(other.sha_)) {}
  AssetUpload& operator=(AssetUpload&&) = delete;
  ~AssetUpload();

  /// What is held now.
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t size() const { return size_; }
  bool complete() const { return bytes_ == size_; }

  /// Requires no more than the size that was said.  Errors: no space on the disk
  /// (RESOURCE_EXHAUSTED), another writer took over (FAILED_PRECONDITION).
  absl::Status append(std::string_view chunk);
  /// Requires `complete()`.  INVALID_ARGUMENT where the bytes have another digest, which the
  /// message is, hexadecimal; they are dropped.
  absl::Status finish();

 private:
  friend class AssetStore;
  AssetUpload(AssetStore& store, std::string digest, std::uint64_t size, std::uint64_t writer,
              Descriptor file)
      : store_(&store),
        digest_(std::move(digest)),
        size_(size),
        writer_(writer),
        file_(std::move(file)) {}

  AssetStore* store_;  // null once moved from or ended
  std::string digest_;
  std::uint64_t size_, writer_, bytes_ = 0;
  Descriptor file_;
  Sha256 sha_;
};

/// Thread-safe.  Digests are 32 bytes.
class AssetStore {
 public:
  /// FAILED_PRECONDITION where another server uses the directory; INVALID_ARGUMENT where it cannot
  /// be written to.
  static absl::StatusOr<std::unique_ptr<AssetStore>> open(const AssetStoreOptions& options);
  ~AssetStore();

  struct Held {
    bool whole = false;
    std::uint64_t bytes = 0;  ///< of a broken upload: where another one may go on
  };
  Held held(const std::string& digest) const;

  /// Begins, or goes on at `offset`, which may not be beyond what is held; what is held beyond it
  /// is forgotten.  Takes as long as reading what is held does.
  ///
  /// Errors: INVALID_ARGUMENT (offset), RESOURCE_EXHAUSTED (over the limit for one file; no room
  /// for it among files in use), FAILED_PRECONDITION (being uploaded by another; held already).
  absl::StatusOr<AssetUpload> upload(const std::string& digest, std::uint64_t size,
                                     std::uint64_t offset);

  /// The file, which may be read even if it goes meanwhile.  NOT_FOUND where it is not held whole.
  absl::StatusOr<OpenFile> read(const std::string& digest);
  /// For a file whose bytes turned out to be others than its digest's.
  void drop(const std::string& digest);

  /// Keeps files from going as long as it lives.
  class Pins {
   public:
    Pins(AssetStore& store, std::vector<std::string> digests);
    ~Pins();
    Pins(const Pins&) = delete;
    Pins& operator=(const Pins&) = delete;

   private:
    AssetStore& store_;
    std::vector<std::string> digests_;
  };

  std::uint64_t max_asset_bytes() const;
  std::uint64_t bytes() const;  ///< of all files, and of what is on its way

 private:
  friend class AssetUpload;
  struct State;
  explicit AssetStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace lucerna
