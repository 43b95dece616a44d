#include "tests/fuzz/input_files.h"

#include <absl/status/status.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace lucerna::fuzz {
namespace {

constexpr std::string_view kMark = "\n#FILE ";

}  // namespace

UnnamedFile::UnnamedFile(std::string_view bytes) : fd_(::memfd_create("input", MFD_CLOEXEC)) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_.get(), bytes.data(), bytes.size());
    if (n <= 0) std::abort();
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

std::string UnnamedFile::path() const { return "/proc/self/fd/" + std::to_string(fd_.get()); }

Descriptor UnnamedFile::open() const {
  return Descriptor(::open(path().c_str(), O_RDONLY | O_CLOEXEC));
}

InputFiles::InputFiles(std::string_view input, std::string main) {
  for (std::string name = std::move(main);;) {
    const std::size_t mark = input.find(kMark);
    files_.emplace_back(std::move(name), input.substr(0, mark));
    if (mark == std::string_view::npos) return;
    input.remove_prefix(mark + kMark.size());
    const std::size_t end = std::min(input.find('\n'), input.size());
    name = input.substr(0, end);
    input.remove_prefix(std::min(end + 1, input.size()));
  }
}

absl::StatusOr<OpenFile> InputFiles::open(const std::string& path, const std::string& name) {
  const auto found = std::find_if(files_.begin(), files_.end(),
                                  [&](const auto& file) { return file.first == path; });
  if (found == files_.end()) return absl::NotFoundError("file \"" + name + "\" does not exist");
  return OpenFile{UnnamedFile(found->second).open(), found->second.size()};
}

}  // namespace lucerna::fuzz
