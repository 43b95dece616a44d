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

/// Names that files can be opened by.
class FileSource {
 public:
  virtual ~FileSource() = default;

  /// The regular file called `path`, without `.` and `..`, at its beginning.  Messages say `name`,
  /// by which it was asked for.  Errors: NOT_FOUND where there is none, INVALID_ARGUMENT where it
  /// may not be read, FAILED_PRECONDITION where it is not there yet.
  virtual absl::StatusOr<OpenFile> open(const std::string& path, const std::string& name) = 0;
};

/// The parts of a path between its slashes.
std::vector<std::string> path_components(std::string_view path);

/// Reads up to `size` bytes from where the file stands; fewer only at its end, -1 on an error.
std::int64_t read_fully(int fd, char* to, std::size_t size);

}  // namespace lucerna
