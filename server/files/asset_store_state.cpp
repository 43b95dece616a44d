// The entries of an AssetStore: their files, the room on the disk, and the quotas of owners.

#include <fcntl.h>
#include <fmt/format.h>

#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "server/files/asset_store.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;

constexpr char kPart[] = ".part";
constexpr char kOwner[] = ".owner";
// Longer than any name of a token file.
constexpr std::size_t kMostOwnerBytes = 256;

bool is_digest(const std::string& name) {
  return name.size() == 2 * kSha256Bytes &&
         name.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string bytes_of(const std::string& hexadecimal) {
  std::string bytes;
  for (std::size_t i = 0; i < hexadecimal.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hexadecimal.substr(i, 2), nullptr, 16));
  return bytes;
}

/// The content of the file; empty if it cannot be read.
std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMostOwnerBytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace

fs::path AssetStore::whole(const std::string& digest) const {
  return directory_ / hexadecimal(digest);
}
fs::path AssetStore::part(const std::string& digest) const { return whole(digest) += kPart; }
fs::path AssetStore::owner(const std::string& digest) const { return whole(digest) += kOwner; }

void AssetStore::find_files() {
  std::error_code error;
  std::vector<std::string> owned;
  for (const fs::directory_entry& file : fs::directory_iterator(directory_, error)) {
    const std::string name = file.path().stem().string(), extension = file.path().extension();
    if (!is_digest(name)) continue;
    if (extension == kOwner) owned.push_back(bytes_of(name));
    if (!(extension.empty() || extension == kPart)) continue;
    Entry entry;
    entry.whole = extension.empty();
    entry.bytes = entry.reserved = file.file_size(error);
    const auto age = fs::file_time_type::clock::now() - file.last_write_time(error);
    entry.touched = Clock::now() - std::chrono::duration_cast<Clock::duration>(age);
    if (!entry.whole) entry.written = entry.touched;
    entry.unread = !entry.whole && entry.bytes >= kMarkBytes;
    // If both exist, the server ended between finish and removal.  The whole file is valid.
    const auto [place, is_new] = entries_.try_emplace(bytes_of(name), std::move(entry));
    if (is_new) continue;
    if (entry.whole) place->second = std::move(entry);
    fs::remove(part(place->first), error);
  }
  for (const std::string& digest : owned) {
    const auto found = entries_.find(digest);
    if (found == entries_.end()) {
      fs::remove(owner(digest), error);
    } else {
      found->second.owner = text_of(owner(digest));
    }
  }
}

void AssetStore::hash_parts(const std::stop_token& stop) {
  std::vector<std::string> parts;
  {
    const std::lock_guard guard(mutex_);
    for (const auto& [digest, entry] : entries_)
      if (entry.unread) parts.push_back(digest);
  }
  std::string bytes(kMarkBytes, '\0');
  for (const std::string& digest : parts) {
    const Descriptor file(::open(part(digest).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
    Sha256 sha;
    for (bool goes_on = true; goes_on && !stop.stop_requested();) {
      goes_on = file.get() >= 0 && read_fully(file.get(), bytes.data(), bytes.size()) ==
                                       static_cast<std::int64_t>(bytes.size());
      if (goes_on) sha.add(bytes);
      const std::lock_guard guard(mutex_);
      const auto found = entries_.find(digest);
      // Deleted, or sent again from the start.
      if (found == entries_.end() || !found->second.unread) break;
      found->second.unread = goes_on;
      if (goes_on) found->second.marks.push_back(sha.copy());
    }
  }
}

void AssetStore::touch(Entry& entry) {
  entry.used = ++uses_;
  entry.touched = Clock::now();
}

void AssetStore::remove(Entries::iterator entry) {
  std::error_code ignored;
  fs::remove(entry->second.whole ? whole(entry->first) : part(entry->first), ignored);
  if (!entry->second.owner.empty()) fs::remove(owner(entry->first), ignored);
  entries_.erase(entry);
}

template <typename MayGo>
auto AssetStore::oldest(MayGo&& may_go) -> Entries::iterator {
  auto found = entries_.end();
  for (auto e = entries_.begin(); e != entries_.end(); ++e)
    if (may_go(*e) && (found == entries_.end() || e->second.used < found->second.used)) found = e;
  return found;
}

bool AssetStore::remove_one() {
  for (const bool whole : {false, true}) {
    const auto entry =
        oldest([&](const auto& e) { return e.second.whole == whole && !in_use(e.second); });
    if (entry == entries_.end()) continue;
    remove(entry);
    return true;
  }
  return false;
}

void AssetStore::remove_old_parts() {
  const Clock::time_point now = Clock::now();
  for (auto e = entries_.begin(); e != entries_.end();) {
    const auto entry = e++;
    if (!entry->second.whole && !in_use(entry->second) &&
        now - entry->second.written > options_.keep_parts)
      remove(entry);
  }
}

absl::StatusOr<std::uint64_t> AssetStore::start(const std::string& digest, std::uint64_t size,
                                                std::uint64_t offset, const AssetOwner& sender) {
  if (size > options_.max_asset_bytes)
    return absl::ResourceExhaustedError(
        fmt::format("an asset of {} bytes, allowed: at most {}", size, options_.max_asset_bytes));
  remove_old_parts();
  Entry& entry = entries_[digest];
  if (entry.whole) return absl::FailedPreconditionError("the server already has the asset");
  if (entry.writer != 0 && Clock::now() - entry.written < options_.patience)
    return absl::FailedPreconditionError("the asset is being uploaded by another client");
  if (offset > entry.bytes || offset > size) {
    const std::uint64_t held = std::min(entry.bytes, size);
    if (entry.bytes == 0) entries_.erase(digest);
    return absl::InvalidArgumentError(fmt::format(
        "header.offset_bytes = {}, allowed: [0, {}], the bytes that the server has", offset, held));
  }
  if (entry.unread && offset > 0)
    return absl::FailedPreconditionError("the server still reads what it has of the asset");
  entry.unread = false;
  entry.writer = ++writers_;  // free_space() does not delete it
  entry.reserved = entry.bytes;
  entry.coming = 0;
  const std::uint64_t more = size > entry.bytes ? size - entry.bytes : 0;
  absl::Status room = free_quota(digest, entry.bytes + more, sender);
  // Only bytes that arrive delete files of others.
  if (room.ok() && !may_fit(more))
    room = absl::ResourceExhaustedError(
        fmt::format("no room for an asset of {} bytes: assets in use fill this server's {}", size,
                    options_.budget_bytes));
  if (!room.ok()) {
    entry.writer = 0;
    if (entry.bytes == 0) entries_.erase(digest);
    return room;
  }
  entry.reserved = entry.bytes + more;
  entry.written = Clock::now();
  touch(entry);
  set_owner(digest, entry, sender.name);
  return entry.writer;
}

bool AssetStore::may_fit(std::uint64_t size) const {
  std::uint64_t needed = size;
  for (const auto& [digest, e] : entries_) needed += in_use(e) ? e.reserved : 0;
  return needed <= options_.budget_bytes;
}

bool AssetStore::free_space(std::uint64_t size) {
  std::uint64_t sum = size;
  for (const auto& [digest, e] : entries_) sum += e.bytes + e.coming;
  while (sum > options_.budget_bytes) {
    const auto entry = oldest([](const auto& e) { return !in_use(e.second); });
    if (entry == entries_.end()) return false;
    sum -= entry->second.bytes;
    remove(entry);
  }
  return true;
}

absl::Status AssetStore::free_quota(const std::string& digest, std::uint64_t size,
                                    const AssetOwner& sender) {
  if (sender.most_bytes == 0) return absl::OkStatus();
  const Clock::time_point now = Clock::now();
  const auto is_senders = [&](const auto& e) {
    return e.first != digest && e.second.owner == sender.name;
  };
  const auto may_go = [&](const auto& e) {
    return is_senders(e) && !in_use(e.second) && now - e.second.touched >= options_.keep_owned;
  };
  std::uint64_t taken = 0, kept = 0;
  for (const auto& e : entries_) {
    if (!is_senders(e)) continue;
    taken += e.second.reserved;
    kept += may_go(e) ? 0 : e.second.reserved;
  }
  if (size > sender.most_bytes || kept > sender.most_bytes - size) {
    absl::Status status = absl::ResourceExhaustedError(fmt::format(
        "a file of {} bytes: files of \"{}\" take {} bytes, {} of them lately used, allowed: {}",
        size, sender.name, taken, kept, sender.most_bytes));
    status.SetPayload(kOverQuotaPayload, absl::Cord());
    return status;
  }
  while (taken > sender.most_bytes - size) {
    const auto entry = oldest(may_go);
    taken -= entry->second.reserved;
    remove(entry);
  }
  return absl::OkStatus();
}

void AssetStore::set_owner(const std::string& digest, Entry& entry, const std::string& name) {
  if (entry.owner == name) return;
  entry.owner = name;
  std::error_code ignored;
  if (name.empty()) {
    fs::remove(owner(digest), ignored);
  } else {
    // If this fails, only the next server does not know the owner.
    std::ofstream(owner(digest), std::ios::binary | std::ios::trunc) << name;
  }
}

AssetStore::Entry* AssetStore::entry_of(const std::string& digest, std::uint64_t writer) {
  const auto found = entries_.find(digest);
  return found == entries_.end() || found->second.writer != writer ? nullptr : &found->second;
}

}  // namespace lucerna
