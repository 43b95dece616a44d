// Records which lights have a case in which suite, so that a test can name a missing one.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tests/lights/area_lights.h"

namespace lucerna::testing {

struct Participant {
  std::string kind;
  LightTraits traits;
};

/// Makes the lights of all cases, by the name of the suite.  Complete once main() has begun.
inline std::map<std::string_view, std::vector<Participant (*)()>>& participants() {
  static std::map<std::string_view, std::vector<Participant (*)()>> all;
  return all;
}

template <typename Case>
bool takes_part(std::string_view suite) {
  participants()[suite].push_back([] {
    const auto light = Case::make({});
    return Participant{kind_of(light), light.traits()};
  });
  return true;
}

}  // namespace lucerna::testing
