// Places in the files of a scene.
#pragma once

#include <absl/status/status.h>

#include <string>

#include "server/description/shared_text.h"

namespace lucerna {

/// A place in a file.  `file` is relative to the scene root.  In a glTF file it ends with "#" and a
/// JSON pointer, such as "room.gltf#/nodes/3", and `line` is 0.
struct SourceLocation {
  SharedText file;
  int line = 0;    ///< from 1; 0: the file as a whole
  int column = 0;  ///< from 1
};

/// "file:line:column".  Files without lines have their place in the name.
std::string text_of(const SourceLocation& where);

/// `status` with file:line:column before its message.  OK is returned unchanged.
absl::Status located(const absl::Status& status, const SourceLocation& where);

}  // namespace lucerna
