// Pictures and photometric files of extreme numbers.
#pragma once

#include <map>
#include <string>

#include "tests/server/extremes/extreme_numbers.h"

namespace lucerna::testing {

/// Files by their names, which the lines of extreme_scenes.h use: picture.pfm, square.pfm (as wide
/// as high), luminaire.ies, luminaire.ldt.  All can be read, but for one in a few luminaires of
/// which a product of numbers leaves the range of doubles.
std::map<std::string, std::string> extreme_files(ExtremeNumbers& numbers);

}  // namespace lucerna::testing
