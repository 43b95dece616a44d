// Records which lights have a case in which suite, so that a test can name a missing one.
#pragma once

#include <map>
#include <set>
#include <string_view>
#include <typeindex>

namespace lucerna::testing {

/// The float types of the lights of all cases, by the name of the suite.  Complete once main() has
/// begun.
inline std::map<std::string_view, std::set<std::type_index>>& participants() {
  static std::map<std::string_view, std::set<std::type_index>> all;
  return all;
}

template <typename Light>
bool takes_part(std::string_view suite) {
  participants()[suite].insert(typeid(Light));
  return true;
}

}  // namespace lucerna::testing
