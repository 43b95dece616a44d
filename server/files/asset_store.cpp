#include "server/files/asset_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <map>
#include <mutex>
#include <system_error>
#include <tuple>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/runtime/scheduling.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReadBytes = std::size_t{1} << 20;
constexpr int kBulkNiceness = 10;  // as in the bulk lane

bool is_full(int error) { return error == ENOSPC || error == EDQUOT; }

absl::Status taken_over() {
  return absl::FailedPreconditionError("another client took over the upload of this asset");
}

absl::Status disk_error(int error) {
  const std::string why = std::generic_category().message(error);
  if (is_full(error))
    return absl::ResourceExhaustedError("no space on the disk that keeps uploaded assets");
  return absl::InternalError("cannot write an uploaded asset: " + why);
}

constexpr char kTemporaryName[] = "lucernad-assets-";

/// The file whose lock says that a server uses the directory.
Descriptor open_lock(const fs::path& directory, int flags) {
  return Descriptor(::open((directory / "lock").c_str(), flags | O_CLOEXEC | O_NOFOLLOW, 0600));
}
bool take_lock(const Descriptor& lock) { return flock(lock.get(), LOCK_EX | LOCK_NB) == 0; }

/// Removes what killed servers of this user left in `parent`.
void remove_left_directories(const fs::path& parent) {
  std::error_code error;
  for (fs::directory_iterator at(parent, error), end; !error && at != end; at.increment(error)) {
    if (!at->path().filename().string().starts_with(kTemporaryName)) continue;
    struct stat found {};
    if (lstat(at->path().c_str(), &found) != 0 || !S_ISDIR(found.st_mode) ||
        found.st_uid != geteuid())
      continue;
    const Descriptor lock = open_lock(at->path(), O_RDWR);
    std::error_code ignored;
    if (lock.get() >= 0 && take_lock(lock)) fs::remove_all(at->path(), ignored);
  }
}

/// A new directory in `parent` with its lock.  Empty if that is impossible.
std::pair<fs::path, Descriptor> make_temporary_directory(const fs::path& parent) {
  constexpr int kMostTries = 100;
  for (int i = 0; i < kMostTries; ++i) {
    std::string name = (parent / kTemporaryName).string() + "XXXXXX";
    if (mkdtemp(name.data()) == nullptr) break;
    Descriptor lock = open_lock(name, O_RDWR | O_CREAT);
    struct stat found {};
    // A server that starts now may have removed the directory before it was locked.
    if (lock.get() >= 0 && take_lock(lock) && fstat(lock.get(), &found) == 0 && found.st_nlink > 0)
      return {name, std::move(lock)};
  }
  return {fs::path(), Descriptor(-1)};
}

}  // namespace

absl::StatusOr<std::unique_ptr<AssetStore>> AssetStore::open(const AssetStoreOptions& options) {
  std::unique_ptr<AssetStore> store(new AssetStore(options));
  std::error_code error;
  if (options.directory.empty()) {
    const fs::path parent = fs::temp_directory_path(error);
    if (!error) {
      remove_left_directories(parent);
      std::tie(store->directory_, store->lock_) = make_temporary_directory(parent);
    }
    if (store->directory_.empty())
      return absl::InvalidArgumentError("cannot make a temporary directory for uploaded assets");
    store->temporary_ = true;
  } else {
    store->directory_ = options.directory;
    fs::create_directories(store->directory_, error);
    store->lock_ = open_lock(store->directory_, O_RDWR | O_CREAT);
    if (store->lock_.get() < 0)
      return absl::InvalidArgumentError(
          fmt::format("asset directory \"{}\" cannot be written to", options.directory));
    if (!take_lock(store->lock_))
      return absl::FailedPreconditionError(
          fmt::format("asset directory \"{}\" is in use by another server", options.directory));
  }
  store->find_files();
  store->remove_old_parts();
  if (!store->free_space(0))
    return absl::InternalError("deleting unused assets does not make enough room");
  store->hashing_ = std::jthread([s = store.get()](const std::stop_token& stop) {
    set_thread_niceness(kBulkNiceness);
    s->hash_parts(stop);
  });
  return store;
}

AssetStore::~AssetStore() {
  if (!temporary_) return;
  std::error_code ignored;
  fs::remove_all(directory_, ignored);
}

AssetStore::Held AssetStore::held(const std::string& digest) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(digest);
  if (found == entries_.end()) return {};
  // A client that checks for an asset is about to use it.
  touch(found->second);
  return {found->second.whole, found->second.bytes};
}

absl::StatusOr<AssetUpload> AssetStore::upload(const std::string& digest, std::uint64_t size,
                                               std::uint64_t offset, const AssetOwner& sender,
                                               const std::stop_token& stop) {
  std::uint64_t writer = 0;
  {
    const std::lock_guard lock(mutex_);
    LUCERNA_ASSIGN_OR_RETURN(writer, start(digest, size, offset, sender));
  }
  const std::string path = part(digest);
  // ext4 waits for the disk when a file is closed that was truncated to nothing.
  if (offset == 0) ::unlink(path.c_str());
  AssetUpload upload(
      *this, digest, size, writer,
      Descriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600)));
  if (upload.file_.get() < 0) return disk_error(errno);
  LUCERNA_RETURN_IF_ERROR(upload.go_on_at(offset, stop));
  return upload;
}

absl::Status AssetUpload::go_on_at(std::uint64_t offset, const std::stop_token& stop) {
  AssetStore& store = *store_;
  {
    const std::lock_guard lock(store.mutex_);
    AssetStore::Entry* const entry = store.entry_of(digest_, writer_);
    if (entry == nullptr) return taken_over();
    const std::uint64_t kept = std::min<std::uint64_t>(entry->marks.size(), offset / kMarkBytes);
    entry->marks.resize(kept);
    if (kept > 0) sha_ = entry->marks.back().copy();
    bytes_ = kept * kMarkBytes;
  }
  ::lseek(file_.get(), static_cast<off_t>(bytes_), SEEK_SET);
  std::string chunk(kReadBytes, '\0');
  while (bytes_ < offset && !stop.stop_requested()) {
    const std::int64_t n =
        read_fully(file_.get(), chunk.data(),
                   static_cast<std::size_t>(std::min<std::uint64_t>(kReadBytes, offset - bytes_)));
    if (n <= 0) return absl::InternalError("cannot read the uploaded part of an asset");
    hash(std::string_view(chunk).substr(0, static_cast<std::size_t>(n)));
  }
  {
    // Also of an upload that was stopped, so that the next one goes on from there.
    const std::lock_guard lock(store.mutex_);
    if (AssetStore::Entry* entry = store.entry_of(digest_, writer_)) entry->take(marks_);
  }
  if (bytes_ < offset) return absl::CancelledError("the upload was cancelled");
  if (offset > 0 && ftruncate(file_.get(), static_cast<off_t>(offset)) != 0)
    return disk_error(errno);
  const std::lock_guard lock(store.mutex_);
  if (AssetStore::Entry* entry = store.entry_of(digest_, writer_)) entry->bytes = offset;
  return absl::OkStatus();
}

absl::Status AssetUpload::append(std::string_view chunk) {
  AssetStore& store = *store_;
  {
    const std::lock_guard lock(store.mutex_);
    AssetStore::Entry* entry = store.entry_of(digest_, writer_);
    if (entry == nullptr) return taken_over();
    if (!store.free_space(chunk.size()))
      return absl::ResourceExhaustedError(
          fmt::format("no room for the next {} bytes of an asset: assets in use fill this "
                      "server's {}",
                      chunk.size(), store.options_.budget_bytes));
    entry->coming = chunk.size();  // other uploads must not take this room
  }
  // Written without the lock.  If another writer takes over meanwhile, the digest will not match.
  const int error = write(chunk);
  if (error == 0) hash(chunk);
  std::unique_lock lock(store.mutex_);
  AssetStore::Entry* entry = store.entry_of(digest_, writer_);
  if (entry == nullptr) return taken_over();
  entry->coming = 0;
  if (error != 0) {
    // What arrived would keep smaller files from the disk.
    if (is_full(error)) store.remove(store.entries_.find(digest_));
    if (is_full(error)) store_ = nullptr;
    return disk_error(error);
  }
  entry->take(marks_);
  entry->bytes = bytes_;
  entry->written = AssetStore::Clock::now();
  return absl::OkStatus();
}

void AssetUpload::hash(std::string_view chunk) {
  while (!chunk.empty()) {
    const std::string_view piece = chunk.substr(0, kMarkBytes - bytes_ % kMarkBytes);
    sha_.add(piece);
    bytes_ += piece.size();
    if (bytes_ % kMarkBytes == 0) marks_.push_back(sha_.copy());
    chunk.remove_prefix(piece.size());
  }
}

int AssetUpload::write(std::string_view chunk) {
  AssetStore& store = *store_;
  while (!chunk.empty()) {
    const ssize_t n = store.options_.write(file_.get(), chunk.data(), chunk.size());
    if (n >= 0) {
      chunk.remove_prefix(static_cast<std::size_t>(n));
      continue;
    }
    const int error = errno;
    if (error == EINTR) continue;
    if (!is_full(error)) return error;
    const std::lock_guard lock(store.mutex_);
    if (!store.remove_one()) return error;
  }
  return 0;
}

absl::Status AssetUpload::finish() {
  AssetStore& store = *store_;
  const std::string found = sha_.finish();
  if (found != digest_) {
    std::exchange(store_, nullptr)->drop(digest_);
    return absl::InvalidArgumentError(hexadecimal(found));
  }
  const std::lock_guard lock(store.mutex_);
  AssetStore::Entry* entry = store.entry_of(digest_, writer_);
  if (entry == nullptr) return taken_over();
  std::error_code error;
  fs::rename(store.part(digest_), store.whole(digest_), error);
  if (error) return disk_error(error.value());
  entry->whole = true;
  entry->marks = std::vector<Sha256>();
  entry->reserved = entry->bytes;
  entry->writer = 0;
  store_ = nullptr;
  return absl::OkStatus();
}

AssetUpload::~AssetUpload() {
  if (store_ == nullptr) return;
  AssetStore& store = *store_;
  const std::lock_guard lock(store.mutex_);
  AssetStore::Entry* entry = store.entry_of(digest_, writer_);
  if (entry == nullptr) return;
  entry->writer = 0;
  entry->reserved = entry->bytes;
  if (entry->bytes == 0) store.remove(store.entries_.find(digest_));
}

absl::StatusOr<OpenFile> AssetStore::read(const std::string& digest) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(digest);
  if (found == entries_.end() || !found->second.whole)
    return absl::NotFoundError("the server does not have the asset");
  Descriptor file(::open(whole(digest).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (file.get() < 0) {
    // Another program deleted the file.
    remove(found);
    return absl::NotFoundError("the server does not have the asset");
  }
  touch(found->second);
  return OpenFile{std::move(file), found->second.bytes};
}

void AssetStore::drop(const std::string& digest) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(digest);
  if (found != entries_.end()) remove(found);
}

AssetStore::Pins::Pins(AssetStore& store, std::vector<std::string> digests) : store_(store) {
  const std::lock_guard lock(store_.mutex_);
  for (std::string& digest : digests) {
    const auto found = store_.entries_.find(digest);
    if (found == store_.entries_.end()) continue;
    ++found->second.pins;
    digests_.push_back(std::move(digest));
  }
}

AssetStore::Pins::~Pins() {
  const std::lock_guard lock(store_.mutex_);
  for (const std::string& digest : digests_) {
    const auto found = store_.entries_.find(digest);
    // It may have been dropped meanwhile, or uploaded again.
    if (found != store_.entries_.end() && found->second.pins > 0) --found->second.pins;
  }
}

std::uint64_t AssetStore::bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const auto& [digest, e] : entries_) sum += e.reserved;
  return sum;
}

}  // namespace lucerna
