// Files of the sources and of this build.  Only paths.cpp knows their folders.  All other test
// sources compile to the same objects in every folder, so the compiler cache finds them in a new
// clone.
#pragma once

#include <string>
#include <string_view>

namespace lucerna {

/// The absolute path of `name`, which is relative to the root of the sources.
std::string source_path(std::string_view name);

/// The absolute path of tests/data/`name`, or of tests/data.
std::string test_data(std::string_view name = {});

/// The absolute path of `name`, which is relative to the folder of this build.
std::string build_path(std::string_view name);

}  // namespace lucerna
