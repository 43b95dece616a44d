#include "client/library/open_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "proto/common/status_macros.h"

namespace lucerna::client {

absl::StatusOr<OpenFile> OpenFile::open(const std::string& path, const std::string& taken,
                                        int flags) {
  OpenFile result(path,
                  ::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NONBLOCK | flags, 0666));
  struct stat found {};
  if (result.file_ < 0 || ::fstat(result.file_, &found) != 0)
    return result.failed(std::strerror(errno));
  // Reading a pipe would never end.
  if (!S_ISREG(found.st_mode)) return result.failed("is a pipe or a device, allowed: files");
  if (::flock(result.file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return result.failed(taken);
  return result;
}

OpenFile::~OpenFile() {
  if (file_ >= 0) ::close(file_);
}

absl::Status OpenFile::failed(const std::string& why) const {
  return absl::UnknownError(path_ + ": " + why);
}

absl::StatusOr<std::uint64_t> OpenFile::size() const {
  struct stat now {};
  if (::fstat(file_, &now) != 0) return failed(std::strerror(errno));
  return static_cast<std::uint64_t>(now.st_size);
}

absl::Status OpenFile::resize(std::uint64_t size) {
  return ::ftruncate(file_, static_cast<off_t>(size)) == 0 ? absl::OkStatus()
                                                           : failed(std::strerror(errno));
}

absl::Status OpenFile::reserve(std::uint64_t size) {
  LUCERNA_RETURN_IF_ERROR(resize(0));
  int error = 0;
  do {
    error = ::fallocate(file_, 0, 0, static_cast<off_t>(size)) == 0 ? 0 : errno;
  } while (error == EINTR);
  if (error == 0) return absl::OkStatus();
  absl::Status status = failed(std::to_string(size) + " bytes: " + std::strerror(error));
  // With these errors the file system does not support allocation.  Writing then fails later, when
  // the disk is full.
  if (error == EOPNOTSUPP || error == ENOSYS || error == EINVAL) status = resize(size);
  // Releases the space.  Otherwise the length would suggest that the content exists.
  if (!status.ok()) resize(0).IgnoreError();
  return status;
}

/// Transfers all `size` bytes, or returns the error.  `transfer(done)` moves some of the bytes
/// after the first `done`.
template <class Transfer>
absl::Status OpenFile::all_of(std::size_t size, Transfer transfer) const {
  for (std::size_t done = 0; done < size;) {
    const ssize_t n = transfer(done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failed(std::strerror(errno));
    if (n == 0) return failed("became shorter while it was read");
    done += static_cast<std::size_t>(n);
  }
  return absl::OkStatus();
}

absl::Status OpenFile::read(std::uint64_t offset, char* bytes, std::size_t size) const {
  return all_of(size, [&](std::size_t done) {
    return ::pread(file_, bytes + done, size - done, static_cast<off_t>(offset + done));
  });
}

absl::Status OpenFile::write(std::uint64_t offset, std::string_view bytes) {
  return all_of(bytes.size(), [&](std::size_t done) {
    return ::pwrite(file_, bytes.data() + done, bytes.size() - done,
                    static_cast<off_t>(offset + done));
  });
}

absl::Status OpenFile::append(std::string_view bytes) {
  return all_of(bytes.size(), [&](std::size_t done) {
    return ::write(file_, bytes.data() + done, bytes.size() - done);
  });
}

}  // namespace lucerna::client
