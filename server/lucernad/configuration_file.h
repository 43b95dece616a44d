// Configuration files in TOML: one key for each setting, and no tables.
#pragma once

#include <string>
#include <vector>

#include "server/lucernad/setting.h"

namespace lucerna::config {

/// A value that a file sets.
struct FileValue {
  const Setting* setting;
  std::vector<std::string> texts;  ///< in the form that `set` accepts
  std::string place;               ///< "FILE:LINE:COLUMN"
};

struct FileContent {
  std::vector<FileValue> values;
  /// "FILE:LINE:COLUMN: what is wrong".  A syntax error ends the list, since the rest of the file
  /// then has no meaning.
  std::vector<std::string> errors;
};

/// Reads the file.  Checks names and types of the values, but not their ranges.
FileContent read_file(const std::string& path, const std::vector<Setting>& settings);

}  // namespace lucerna::config
