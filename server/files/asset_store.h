// Uploaded files, kept on disk by the SHA-256 of their content.  A file that many scenes and
// clients use is stored once.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/common/sha256.h"
#include "server/files/asset_store_options.h"
#include "server/files/file_source.h"

namespace lucerna {

class AssetStore;

/// Payload of a RESOURCE_EXHAUSTED because of a quota of the caller.
inline constexpr char kOverQuotaPayload[] = "lucerna.over_quota";

/// Who sends a file.
struct AssetOwner {
  std::string name{};
  /// The most bytes of all files that the owner sent; 0: no limit.
  std::uint64_t most_bytes = 0;
};

/// One running upload.  If it is destroyed before its end, the store keeps what arrived, and a
/// later upload may continue there.
class AssetUpload {
 public:
  AssetUpload(AssetUpload&& other) noexcept
      : store_(std::exchange(other.store_, nullptr)),
        digest_(std::move(other.digest_)),
        size_(other.size_),
        writer_(other.writer_),
        bytes_(other.bytes_),
        file_(std::move(other.file_)),
        sha_(std::move(other.sha_)),
        marks_(std::move(other.marks_)) {}
  AssetUpload& operator=(AssetUpload&&) = delete;
  ~AssetUpload();

  /// Bytes in the store now.
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t size() const { return size_; }
  bool complete() const { return bytes_ == size_; }

  /// Requires that bytes() stays at most size().  If the disk is full, the store deletes files that
  /// are not in use, the least recently used first, and tries again.  Errors: no space on the disk
  /// even then (RESOURCE_EXHAUSTED; the store deletes what arrived), another writer took over
  /// (FAILED_PRECONDITION).
  absl::Status append(std::string_view chunk);
  /// Requires `complete()`.  INVALID_ARGUMENT if the bytes have another digest: the store deletes
  /// them.  The message is the digest of the bytes, hexadecimal.
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

  /// Hashes what the file has before `offset`, until `stop`, and drops the rest of it.
  absl::Status go_on_at(std::uint64_t offset, const std::stop_token& stop);
  /// Writes all of the chunk; an error number, or 0.
  int write(std::string_view chunk);
  void hash(std::string_view chunk);

  AssetStore* store_;  // null once moved from or ended
  std::string digest_;
  std::uint64_t size_, writer_, bytes_ = 0;
  Descriptor file_;
  Sha256 sha_;
  std::vector<Sha256> marks_;  // states that the store does not have yet
};

/// Thread-safe.  Digests are 32 bytes.
class AssetStore {
 public:
  /// Opens or makes the directory.  FAILED_PRECONDITION if another server uses it.
  /// INVALID_ARGUMENT if it is not writable.
  static absl::StatusOr<std::unique_ptr<AssetStore>> open(const AssetStoreOptions& options);
  ~AssetStore();

  struct Held {
    bool whole = false;
    std::uint64_t bytes = 0;  ///< of a broken upload; another upload may continue there
  };
  Held held(const std::string& digest) const;

  /// Starts an upload at `offset`, which is at most the number of bytes in the store.  Deletes the
  /// bytes after `offset`.  Reads at most 4 MiB of those before it to hash them, until `stop`.
  /// After a start, the store reads the parts that it finds in a thread of its own.
  ///
  /// The file counts as the sender's, as long as the store has it.
  ///
  /// Errors: INVALID_ARGUMENT (offset), RESOURCE_EXHAUSTED (over the limit for one file; files in
  /// use leave no room; with kOverQuotaPayload, the sender's files leave no room in its quota),
  /// FAILED_PRECONDITION (another client uploads it; its part is not read yet; the store already
  /// has it), CANCELLED.
  absl::StatusOr<AssetUpload> upload(const std::string& digest, std::uint64_t size,
                                     std::uint64_t offset, const AssetOwner& sender = {},
                                     const std::stop_token& stop = {});

  /// The file.  It stays readable even if the store deletes it meanwhile.  NOT_FOUND if it is not
  /// complete.
  absl::StatusOr<OpenFile> read(const std::string& digest);
  /// Deletes a file.  Use it for a file whose bytes do not match its digest.
  void drop(const std::string& digest);

  /// While this object exists, the store does not delete its files.
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
  std::chrono::seconds stall_time() const;
  std::uint64_t bytes() const;  ///< of all files, including those reserved by running uploads

 private:
  friend class AssetUpload;
  struct State;
  explicit AssetStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace lucerna
