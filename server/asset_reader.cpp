#include "server/asset_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

namespace lucerna {
namespace {

constexpr std::size_t kChunkBytes = 1 << 20;

absl::Status leaves_root(const std::string& name) {
  return absl::InvalidArgumentError(
      fmt::format("file name \"{}\" leaves the scene root, allowed: files beneath it", name));
}

std::vector<std::string> components(std::string_view path) {
  std::vector<std::string> parts;
  while (!path.empty()) {
    const std::size_t slash = path.find('/');
    parts.emplace_back(path.substr(0, slash));
    path = slash == std::string_view::npos ? std::string_view{} : path.substr(slash + 1);
  }
  return parts;
}

std::string joined(const std::vector<std::string>& parts) {
  return fmt::format("{}", fmt::join(parts, "/"));
}

/// Opens `path` beneath `root`, or says why not through errno.  Nothing where this kernel (or what
/// filters its calls) knows no openat2.
std::optional<int> open_with_openat2(int root, const std::string& path, int flags) {
  open_how how{};
  how.flags = static_cast<std::uint64_t>(flags);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
  // EAGAIN: something was renamed while a `..` within a link was being resolved.
  for (int attempt = 0; attempt < 16; ++attempt) {
    const long fd = syscall(SYS_openat2, root, path.c_str(), &how, sizeof(how));
    if (fd >= 0) return static_cast<int>(fd);
    if (errno == ENOSYS || errno == EPERM || errno == E2BIG) return std::nullopt;
    if (errno != EAGAIN && errno != EINTR) return -1;
  }
  return -1;
}

/// One component at a time, following no link at all.
int open_without_links(int root, const std::string& path, int flags) {
  const std::vector<std::string> parts = components(path);
  int directory = root;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool last = i + 1 == parts.size();
    const int fd = openat(directory, parts[i].c_str(),
                          last ? flags | O_NOFOLLOW : O_PATH | O_NOFOLLOW | O_CLOEXEC);
    const int error = errno;
    if (directory != root) close(directory);
    if (fd < 0) {
      errno = error;
      return -1;
    }
    struct stat status {};
    if (!last && fstat(fd, &status) == 0 && S_ISLNK(status.st_mode)) {
      close(fd);
      errno = ELOOP;
      return -1;
    }
    directory = fd;
  }
  return directory;
}

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  void add(const char* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
  std::string finish() {
    std::string digest(32, '\0');
    EVP_DigestFinal_ex(context_.get(), reinterpret_cast<unsigned char*>(digest.data()), nullptr);
    return digest;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

/// Reads up to `size` bytes; fewer only at the end of the file, -1 on an error.
ssize_t read_fully(int fd, char* to, std::size_t size) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t n = ::read(fd, to + done, size - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return static_cast<ssize_t>(done);
}

absl::Status too_much(const std::string& name, std::uint64_t limit) {
  return absl::ResourceExhaustedError(fmt::format(
      "file \"{}\": the scene's files exceed {} bytes together, which is the limit", name, limit));
}

absl::Status unreadable(const std::string& name) {
  return absl::InvalidArgumentError(fmt::format("file \"{}\" cannot be read", name));
}

}  // namespace

struct AssetReader::OpenFile {
  Descriptor fd;
  std::uint64_t size;
};

AssetReader::Descriptor::Descriptor(Descriptor&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)) {}

AssetReader::Descriptor& AssetReader::Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

AssetReader::Descriptor::~Descriptor() {
  if (fd_ >= 0) close(fd_);
}

AssetReader::AssetReader(Descriptor root, const AssetReaderOptions& options)
    : root_(std::move(root)), options_(options), remaining_bytes_(options.max_total_bytes) {}

absl::StatusOr<AssetReader> AssetReader::open(const std::string& root,
                                              const AssetReaderOptions& options) {
  const int fd = ::open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0)
    return absl::NotFoundError(
        fmt::format("scene root \"{}\" is no directory that can be opened", root));
  return AssetReader(Descriptor(fd), options);
}

absl::StatusOr<std::string> AssetReader::resolve(const std::string& name,
                                                 const std::string& relative_to) const {
  if (name.empty()) return absl::InvalidArgumentError("file name \"\" is empty");
  if (name.find('\0') != std::string::npos)
    return absl::InvalidArgumentError("file name holds a zero byte");
  if (name.front() == '/') return leaves_root(name);
  std::vector<std::string> path = components(relative_to);
  if (!path.empty()) path.pop_back();
  for (std::string& part : components(name)) {
    if (part.empty() || part == ".") continue;
    if (part != "..") {
      path.push_back(std::move(part));
    } else if (path.empty()) {
      return leaves_root(name);
    } else {
      path.pop_back();
    }
  }
  if (path.empty())
    return absl::InvalidArgumentError(fmt::format("\"{}\" is not a regular file", name));
  return joined(path);
}

absl::StatusOr<AssetReader::OpenFile> AssetReader::open_beneath(const std::string& name,
                                                                const std::string& path) const {
  // O_NONBLOCK: opening a FIFO must not wait for a writer.
  constexpr int kFlags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
  std::optional<int> opened;
  if (options_.use_openat2) opened = open_with_openat2(root_.get(), path, kFlags);
  Descriptor fd(opened ? *opened : open_without_links(root_.get(), path, kFlags));
  if (fd.get() < 0) {
    // EXDEV: openat2 met the root's border.  ELOOP: a link where none is followed, or a circle.
    if (errno == EXDEV || errno == ELOOP) return leaves_root(name);
    if (errno == ENOENT || errno == ENOTDIR)
      return absl::NotFoundError(fmt::format("file \"{}\" does not exist", name));
    return unreadable(name);
  }
  struct stat status {};
  if (fstat(fd.get(), &status) != 0) return unreadable(name);
  if (!S_ISREG(status.st_mode))
    return absl::InvalidArgumentError(fmt::format("\"{}\" is not a regular file", name));
  return OpenFile{std::move(fd), static_cast<std::uint64_t>(status.st_size)};
}

absl::StatusOr<AssetContent> AssetReader::read(const std::string& name,
                                               const std::string& relative_to) {
  auto path = resolve(name, relative_to);
  if (!path.ok()) return path.status();
  auto file = open_beneath(name, *path);
  if (!file.ok()) return file.status();
  if (file->size > remaining_bytes_) return too_much(name, options_.max_total_bytes);

  AssetContent content{*path, std::string(file->size, '\0')};
  const ssize_t n = read_fully(file->fd.get(), content.bytes.data(), content.bytes.size());
  if (n < 0) return unreadable(name);
  content.bytes.resize(static_cast<std::size_t>(n));
  remaining_bytes_ -= content.bytes.size();

  if (seen_.insert(content.name).second) {
    Sha256 sha;
    sha.add(content.bytes.data(), content.bytes.size());
    assets_.push_back({content.name, sha.finish(), content.bytes.size()});
  }
  return content;
}

absl::StatusOr<AssetContent> AssetReader::read_unpacked(const std::string& name,
                                                        const std::string& relative_to) {
  auto packed = read(name, relative_to);
  if (!packed.ok() || packed->bytes.compare(0, 2, "\x1f\x8b") != 0) return packed;

  z_stream stream{};
  constexpr int kGzipOnly = 15 + 16;
  if (inflateInit2(&stream, kGzipOnly) != Z_OK) return unreadable(name);
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, &inflateEnd);
  std::string& in = packed->bytes;
  std::string out;
  std::string chunk(kChunkBytes, '\0');
  std::size_t consumed = 0;
  int result = Z_OK;
  while (result == Z_OK) {
    // zlib counts in 32 bits; hand it a part at a time.
    const std::size_t part = std::min<std::size_t>(in.size() - consumed, std::size_t{1} << 30);
    stream.next_in = reinterpret_cast<Bytef*>(in.data() + consumed);
    stream.avail_in = static_cast<uInt>(part);
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = static_cast<uInt>(chunk.size());
    result = inflate(&stream, Z_NO_FLUSH);
    consumed += part - stream.avail_in;
    const std::size_t produced = chunk.size() - stream.avail_out;
    if (produced > remaining_bytes_) return too_much(name, options_.max_total_bytes);
    remaining_bytes_ -= produced;
    out.append(chunk, 0, produced);
  }
  if (result != Z_STREAM_END)
    return absl::InvalidArgumentError(
        fmt::format("file \"{}\": its gzip data are broken or cut off", name));
  packed->bytes = std::move(out);
  return packed;
}

absl::StatusOr<std::vector<Asset>> AssetReader::rehash(const std::vector<Asset>& assets) const {
  std::vector<Asset> now;
  std::string chunk(kChunkBytes, '\0');
  for (const Asset& asset : assets) {
    auto path = resolve(asset.name, "");
    if (!path.ok()) return path.status();
    auto file = open_beneath(asset.name, *path);
    if (!file.ok()) return file.status();
    Sha256 sha;
    std::uint64_t bytes = 0;
    for (ssize_t n = 1; n > 0;) {
      n = read_fully(file->fd.get(), chunk.data(), chunk.size());
      if (n < 0) return unreadable(asset.name);
      sha.add(chunk.data(), static_cast<std::size_t>(n));
      bytes += static_cast<std::uint64_t>(n);
    }
    now.push_back({asset.name, sha.finish(), bytes});
  }
  return now;
}

}  // namespace lucerna
