#include "server/runtime/text_file.h"

#include <absl/status/status.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

namespace lucerna {

absl::StatusOr<std::string> read_text_file(const std::string& path) {
  const auto unreadable = [](const std::string& why) {
    return absl::InvalidArgumentError("cannot be read: " + why);
  };
  // Without O_NONBLOCK, a named pipe waits for a writer.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return unreadable(std::generic_category().message(errno));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(fdopen(descriptor, "rb"),
                                                             &std::fclose);
  struct stat found {};
  if (fstat(descriptor, &found) != 0) return unreadable(std::generic_category().message(errno));
  if (S_ISDIR(found.st_mode)) return unreadable(std::generic_category().message(EISDIR));
  if (!S_ISREG(found.st_mode)) return unreadable("it is a pipe or a device, allowed: files");
  constexpr std::size_t kChunk = std::size_t{1} << 12;
  std::string text;
  for (;;) {
    const std::size_t begin = text.size();
    text.resize(begin + kChunk);
    const std::size_t read = std::fread(text.data() + begin, 1, kChunk, file.get());
    text.resize(begin + read);
    if (std::ferror(file.get()) != 0) return unreadable(std::generic_category().message(errno));
    if (text.size() > kMostTextFileBytes)
      return unreadable(
          fmt::format("it is too large, allowed: at most {} bytes", kMostTextFileBytes));
    if (read < kChunk) return text;
  }
}

}  // namespace lucerna
