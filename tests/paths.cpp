#include "tests/paths.h"

#include <cstdlib>

namespace lucerna {
namespace {

// testing::LocalServer starts the lucernad of this build, unless the caller's environment names
// another.
const int lucernad_of_this_build =
    ::setenv("LUCERNAD", LUCERNA_BUILD "/bin/lucernad", /*overwrite=*/0);

std::string join(std::string path, std::string_view name) {
  if (!name.empty()) path.append("/").append(name);
  return path;
}

}  // namespace

std::string source_path(std::string_view name) { return join(LUCERNA_SOURCES, name); }
std::string test_data(std::string_view name) { return join(LUCERNA_SOURCES "/tests/data", name); }
std::string build_path(std::string_view name) { return join(LUCERNA_BUILD, name); }

}  // namespace lucerna
