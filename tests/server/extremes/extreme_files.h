// Pictures and photometric files with extreme numbers.
#pragma once

#include <map>
#include <string>

#include "tests/server/extremes/extreme_numbers.h"

namespace lucerna::testing {

/// Files by name, as the lines of extreme_scenes.h use them: picture.pfm, square.pfm (as wide as
/// high), luminaire.ies, luminaire.ldt.  All can be read, except a few luminaires in which a
/// product of numbers leaves the range of doubles.
std::map<std::string, std::string> extreme_files(ExtremeNumbers& numbers);

}  // namespace lucerna::testing
