// The files of one input, without a disk.
//
// An input is one file, or several.  A line "#FILE name" begins a further file.  So an input can
// hold a scene file and the files that it names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/files/file_source.h"

namespace lucerna::fuzz {

/// The bytes of an input as text.
inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// The unit this many times.
inline std::string repeated(std::string_view unit, std::size_t times) {
  std::string text;
  text.reserve(unit.size() * times);
  for (std::size_t i = 0; i < times; ++i) text += unit;
  return text;
}

/// A file that has no name on any disk.  It can be opened by its path while the object exists.
class UnnamedFile {
 public:
  explicit UnnamedFile(std::string_view bytes);
  std::string path() const;
  /// Another descriptor of the file, at its beginning.
  Descriptor open() const;

 private:
  Descriptor fd_;
};

/// The files of an input.
class InputFiles final : public FileSource {
 public:
  /// The bytes before the first line "#FILE name" are the file `main`.  `input` must outlive the
  /// object.
  InputFiles(std::string_view input, std::string main);

  absl::StatusOr<OpenFile> open(const std::string& path, const std::string& name) override;

 private:
  std::vector<std::pair<std::string, std::string_view>> files_;
};

}  // namespace lucerna::fuzz
