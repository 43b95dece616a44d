// The settings that hold, and where each of them comes from.  A flag overrides the environment, the
// environment overrides the configuration file, and the file overrides the default.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "server/lucernad/setting_schema.h"

namespace lucerna::config {

/// What the user gave, by the name of the setting.  `file` is the path of a configuration file, or
/// empty.
struct Given {
  std::map<std::string, std::vector<std::string>> flags;
  std::map<std::string, std::string> environment;  ///< by the whole name: LUCERNAD_...
  std::string file;
};

/// A setting that holds.
struct Held {
  std::string name;
  std::string value;
  std::string source;  ///< "default", "FILE:LINE:COLUMN", "LUCERNAD_..." or "--..."
  bool reloads = false;
};

struct Configuration {
  Options options;
  std::vector<Held> held;  ///< in the order of the schema
  /// One line each.  If there are any, `options` must not be used.
  std::vector<std::string> errors;
  /// Variables of the environment that look like settings but are none.
  std::vector<std::string> warnings;
};

/// Reads the file and combines it with the flags and the environment.  It may be called again, to
/// read a changed file.
Configuration configure(const Given& given);

/// The variables LUCERNAD_* of this process.
std::map<std::string, std::string> environment();

/// One line for each setting: "name = value  (source)".
std::string describe(const Configuration& configuration);

}  // namespace lucerna::config
