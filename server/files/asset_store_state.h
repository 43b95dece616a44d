// The state of an AssetStore: its entries, the room on the disk, and quotas of owners.  Used by the
// files of the store.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "server/files/asset_store.h"

namespace lucerna {

// The state of the digest is kept after each of these: a part continues without being read again.
inline constexpr std::uint64_t kMarkBytes = std::uint64_t{4} << 20;

struct AssetStore::State {
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

  AssetStoreOptions options;
  std::filesystem::path directory;
  bool temporary = false;
  Descriptor lock{-1};

  mutable std::mutex mutex;
  using Entries = std::map<std::string, Entry>;
  Entries entries;
  std::uint64_t uses = 0, writers = 0;

  std::filesystem::path whole(const std::string& digest) const;
  std::filesystem::path part(const std::string& digest) const;
  /// Holds the name of the owner, so that the next server knows it.
  std::filesystem::path owner(const std::string& digest) const;

  /// Fills `entries` from the directory.  Before other threads use the state.
  void find_files();

  /// Computes the states of the digests of parts that arrived before this server started, at the
  /// priority of the bulk lane.  Until then uploads do not continue them.
  void hash_parts(const std::stop_token& stop);

  // Call the functions below with the lock held.

  std::uint64_t reserved() const;
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

  std::jthread hashing;  ///< last: ends first
};

}  // namespace lucerna
