#include "server/pbrt/file_position.h"

#include <fmt/format.h>

namespace lucerna::pbrt {
SourceLocation location(const FilePosition& place) {
  return {place.file != nullptr ? *place.file : SharedText(), place.line, place.column};
}

std::string to_string(const FilePosition& place) {
  if (place.file == nullptr) return "";
  if (place.line == 0) return *place.file;
  return fmt::format("{}:{}:{}", place.file->str(), place.line, place.column);
}

void fail(const FilePosition& place, const std::string& what) {
  fail(place, absl::InvalidArgumentError(what));
}

void fail(const FilePosition& place, const absl::Status& status) {
  const std::string message(status.message().data(), status.message().size());
  throw StatusError(absl::Status(
      status.code(),
      place.file == nullptr ? message : fmt::format("{}: {}", to_string(place), message)));
}

}  // namespace lucerna::pbrt
