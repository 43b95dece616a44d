#include "client/result_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>

namespace lucerna::client {
namespace {

static_assert(std::endian::native == std::endian::little);

absl::Status failed(const std::string& path, const std::string& why) {
  return absl::UnknownError(path + ": " + why);
}

/// All of `bytes`, or what went wrong.  `transfer` is pread or pwrite.
template <class Transfer, class Byte>
absl::Status all_of(Transfer transfer, const std::string& path, int file, Byte* bytes,
                    std::size_t size, std::uint64_t offset) {
  while (size > 0) {
    const ssize_t n = transfer(file, bytes, size, static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failed(path, std::strerror(errno));
    if (n == 0) return failed(path, "is shorter than it was");
    bytes += n;
    offset += static_cast<std::uint64_t>(n);
    size -= static_cast<std::size_t>(n);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ResultFile> ResultFile::open(const std::string& path, const std::string& header,
                                            std::uint64_t rows, std::size_t columns) {
  const int file = ::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
  if (file < 0) return failed(path, std::strerror(errno));
  ResultFile result(path, file, header.size(), rows, columns);
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return failed(path, "another process is writing it");
  const std::uint64_t size = header.size() + rows * columns * sizeof(float);
  struct stat now {};
  if (::fstat(file, &now) != 0) return failed(path, std::strerror(errno));
  if (static_cast<std::uint64_t>(now.st_size) == size) {
    std::string there(header.size(), '\0');
    if (absl::Status s = all_of(::pread, path, file, there.data(), there.size(), 0); !s.ok())
      return s;
    if (there == header) return result;
  }
  if (::ftruncate(file, 0) != 0 || ::ftruncate(file, static_cast<off_t>(size)) != 0)
    return failed(path, std::strerror(errno));
  // Now rather than after hours.  Some file systems cannot say: those fail when they are full.
  if (::fallocate(file, 0, 0, static_cast<off_t>(size)) != 0 && errno == ENOSPC)
    return failed(path, std::to_string(size) + " bytes: " + std::strerror(ENOSPC));
  if (absl::Status s = all_of(::pwrite, path, file, header.data(), header.size(), 0); !s.ok())
    return s;
  return result;
}

ResultFile::ResultFile(ResultFile&& other) noexcept { *this = std::move(other); }

ResultFile& ResultFile::operator=(ResultFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(file_, other.file_);
  std::swap(begin_, other.begin_);
  std::swap(rows_, other.rows_);
  std::swap(columns_, other.columns_);
  return *this;
}

ResultFile::~ResultFile() {
  if (file_ >= 0) ::close(file_);
}

absl::Status ResultFile::write(std::uint64_t first, std::span<const float> values) {
  return all_of(::pwrite, path_, file_, reinterpret_cast<const char*>(values.data()),
                values.size_bytes(), begin_ + first * columns_ * sizeof(float));
}

absl::Status ResultFile::read(std::uint64_t first, std::span<float> values) const {
  return all_of(::pread, path_, file_, reinterpret_cast<char*>(values.data()), values.size_bytes(),
                begin_ + first * columns_ * sizeof(float));
}

}  // namespace lucerna::client
