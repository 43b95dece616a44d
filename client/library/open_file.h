// A file that only one process at a time may have open.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace lucerna::client {

/// Errors are UNKNOWN, with the file's name and the system's message.  Not thread-safe.
class OpenFile {
 public:
  /// Opens or creates `path` for reading and writing, with additional `flags` of open(2).  `taken`
  /// is the error message if another OpenFile, in this process or another one, has the file open.
  /// File systems without locks do not detect that.
  static absl::StatusOr<OpenFile> open(const std::string& path, const std::string& taken,
                                       int flags = 0);
  OpenFile(OpenFile&& other) noexcept
      : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(file_, other.file_);
    return *this;
  }
  ~OpenFile();

  const std::string& path() const { return path_; }
  absl::StatusOr<std::uint64_t> size() const;
  absl::Status resize(std::uint64_t size);
  /// Empties the file and gives it `size` bytes.  Allocates disk space for all of them if the file
  /// system can.  After an error the file is empty.
  absl::Status reserve(std::uint64_t size);

  absl::Status read(std::uint64_t offset, char* bytes, std::size_t size) const;
  absl::Status write(std::uint64_t offset, std::string_view bytes);
  /// Requires that the file was opened with O_APPEND.
  absl::Status append(std::string_view bytes);

 private:
  OpenFile(std::string path, int file) : path_(std::move(path)), file_(file) {}
  absl::Status failed(const std::string& why) const;
  template <class Transfer>
  absl::Status all_of(std::size_t size, Transfer transfer) const;

  std::string path_;
  int file_ = -1;
};

}  // namespace lucerna::client
