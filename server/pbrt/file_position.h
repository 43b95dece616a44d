// Places in scene files, and errors at them.
#pragma once

#include <absl/status/status.h>

#include <string>

#include "proto/common/status_error.h"
#include "server/description/scene_description.h"
#include "server/files/printable.h"

namespace lucerna::pbrt {

/// A place in a file.  The parser owns `file`, which outlives all references to it; null: no place.
struct FilePosition {
  const SharedText* file = nullptr;
  int line = 0;    ///< from 1
  int column = 0;  ///< from 1, in bytes
};

SourceLocation location(const FilePosition& place);

/// "scene.pbrt:12:7".
std::string to_string(const FilePosition& place);

/// Throws a StatusError: INVALID_ARGUMENT with the place before its message.
[[noreturn]] void fail(const FilePosition& place, const std::string& what);

/// Throws `status` (not OK) with the place before its message.
[[noreturn]] void fail(const FilePosition& place, const absl::Status& status);

}  // namespace lucerna::pbrt
