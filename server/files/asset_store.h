// Uploaded files, kept on disk by the SHA-256 of their content.  A file that many scenes and
// clients use is stored once.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "proto/common/sha256.h"
#include "server/files/asset_store_options.h"
#include "server/files/file_source.h"

namespace lucerna {

class AssetStore;

/// The state of the digest is kept after each of these: a part continues without being read again.
inline constexpr std::uint64_t kMarkBytes = std::uint64_t{4} << 20;

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
  Held held(const std::string& digest);

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

  std::uint64_t max_asset_bytes() const { return options_.max_asset_bytes; }
  std::chrono::seconds stall_time() const { return options_.stall_time; }
  std::uint64_t bytes() const;  ///< of all files, including those reserved by running uploads

 private:
  friend class AssetUpload;
  using Clock = std::chrono::steady_clock;

  struct Entry {
    std::uint64_t bytes = 0;     // on disk
    std::uint64_t coming = 0;    // of the chunk that is being written
    std::uint64_t reserved = 0;  // the size that a writer announced, else `bytes`
    bool whole = false;
    std::size_t pins = 0;
    std::uint64_t writer = 0;  // 0: no writer
    Clock::time_point written{};
    std::uint64_t used = 0;       // larger: used later
    Clock::time_point touched{};  // when it was used
    std::string owner{};          // who sent it; empty: nobody in particular
    std::vector<Sha256> marks{};  // of a part: states of its digest, one every few MiB
    bool unread = false;          // a part without marks, which hash_parts() makes

    void take(std::vector<Sha256>& more) {
      std::ranges::move(more, std::back_inserter(marks));
      more.clear();
    }
  };
  using Entries = std::map<std::string, Entry>;

  explicit AssetStore(const AssetStoreOptions& options) : options_(options) {}
  std::filesystem::path whole(const std::string& digest) const;
  std::filesystem::path part(const std::string& digest) const;
  /// Holds the name of the owner, so that the next server knows it.
  std::filesystem::path owner(const std::string& digest) const;

  /// Fills the entries from the directory.  Before other threads use the store.
  void find_files();

  /// Computes the states of the digests of parts that arrived before this server started, at the
  /// priority of the bulk lane.  Until then uploads do not continue them.
  void hash_parts(const std::stop_token& stop);

  // Call the functions below with the lock held.

  void touch(Entry& entry);
  void remove(Entries::iterator entry);
  /// The least recently used of the files for which `may_go`; the end if there is none.
  template <typename MayGo>
  Entries::iterator oldest(MayGo&& may_go);
  static bool in_use(const Entry& e) { return e.pins > 0 || e.writer != 0; }

  /// Deletes the least recently used file that is not in use; parts come first, since no scene can
  /// use them.  Returns false if there is none.
  bool remove_one();
  /// Deletes the parts of uploads that nobody continued.
  void remove_old_parts();
  /// A new writer of an asset of `size` bytes, who has sent `offset` of them.  Errors: those of
  /// AssetStore::upload.
  absl::StatusOr<std::uint64_t> start(const std::string& digest, std::uint64_t size,
                                      std::uint64_t offset, const AssetOwner& sender);
  /// Whether files in use leave `size` bytes of the budget.
  bool may_fit(std::uint64_t size) const;
  /// Makes room on the disk for `size` bytes more.  False if files in use fill the budget.
  bool free_space(std::uint64_t size);
  /// Makes room for `digest`, with `size` bytes, within the quota of its sender: the sender's files
  /// are deleted that nobody used for some time, the least recently used first.  If that is not
  /// enough, deletes nothing and returns RESOURCE_EXHAUSTED with kOverQuotaPayload.
  absl::Status free_quota(const std::string& digest, std::uint64_t size, const AssetOwner& sender);
  /// From now on the file counts as `name`'s.
  void set_owner(const std::string& digest, Entry& entry, const std::string& name);

  /// The entry that `writer` writes; null if another writer took over or the entry was dropped.
  Entry* entry_of(const std::string& digest, std::uint64_t writer);

  AssetStoreOptions options_;
  std::filesystem::path directory_;
  bool temporary_ = false;
  Descriptor lock_{-1};

  mutable std::mutex mutex_;
  Entries entries_;
  std::uint64_t uses_ = 0, writers_ = 0;
  std::jthread hashing_;  ///< last: ends first
};

}  // namespace lucerna
