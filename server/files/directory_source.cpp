#include "server/files/directory_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace lucerna {
namespace {

/// Opens `path` under `root`; on failure -1 and errno.  Nothing if the kernel or a filter of
/// system calls does not allow openat2.
std::optional<int> open_with_openat2(int root, const std::string& path, int flags) {
  open_how how{};
  how.flags = static_cast<std::uint64_t>(flags);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
  // EAGAIN: a rename happened while a `..` within a link was resolved.
  for (int attempt = 0; attempt < 16; ++attempt) {
    const long fd = syscall(SYS_openat2, root, path.c_str(), &how, sizeof(how));
    if (fd >= 0) return static_cast<int>(fd);
    if (errno == ENOSYS || errno == EPERM || errno == E2BIG) return std::nullopt;
    if (errno != EAGAIN && errno != EINTR) return -1;
  }
  return -1;
}

/// Opens one component at a time, without following links.
int open_without_links(int root, const std::string& path, int flags) {
  const std::vector<std::string> parts = path_components(path);
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

}  // namespace

absl::Status leaves_root(const std::string& name) {
  return absl::InvalidArgumentError(
      fmt::format("file name \"{}\" leaves the scene root, allowed: paths inside it", name));
}

absl::Status unreadable(const std::string& name) {
  return absl::InvalidArgumentError(fmt::format("file \"{}\" cannot be read", name));
}

absl::StatusOr<std::unique_ptr<DirectorySource>> DirectorySource::open_root(const std::string& root,
                                                                            bool use_openat2) {
  const int fd = ::open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0)
    return absl::NotFoundError(
        fmt::format("cannot open the scene root \"{}\" as a directory", root));
  return std::unique_ptr<DirectorySource>(new DirectorySource(Descriptor(fd), use_openat2));
}

absl::StatusOr<OpenFile> DirectorySource::open(const std::string& path, const std::string& name) {
  // O_NONBLOCK: opening a FIFO must not wait for a writer.
  constexpr int kFlags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
  std::optional<int> opened;
  if (use_openat2_) opened = open_with_openat2(root_.get(), path, kFlags);
  Descriptor fd(opened ? *opened : open_without_links(root_.get(), path, kFlags));
  if (fd.get() < 0) {
    // EXDEV: openat2 would leave the root.  ELOOP: a link that must not be followed, or a circle of
    // links.
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

}  // namespace lucerna
