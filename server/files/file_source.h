// Where the files of a scene come from.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lucerna {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();
  int get() const { return fd_; }

 private:
  int fd_;
};

struct OpenFile {
  Descriptor fd;
  std::uint64_t size;
};

/// A source of files by name.
class FileSource {
 public:
  virtual ~FileSource() = default;

  /// Opens the regular file `path` at its beginning.  `path` has no `.` and `..`.  Messages use
  /// `name`, the name in the request.  Errors: NOT_FOUND if it does not exist, INVALID_ARGUMENT if
  /// it must not be read, FAILED_PRECONDITION if it was not uploaded yet.
  virtual absl::StatusOr<OpenFile> open(const std::string& path, const std::string& name) = 0;
};

/// The parts of a path between its slashes.
std::vector<std::string> path_components(std::string_view path);

/// Reads up to `size` bytes from the current position; fewer only at the end; -1 on an error.
std::int64_t read_fully(int fd, char* to, std::size_t size);

}  // namespace lucerna
