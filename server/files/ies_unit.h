// The unit of intensity that the keywords of an IES LM-63 file state.
#pragma once

#include <string_view>

#include "server/files/photometric_file.h"

namespace lucerna {

/// Sets `file.flux_unit` and `file.unit` if the lines before "TILT=" state a unit of radiant
/// intensity, such as "[_INTENSITYUNITS] mW/sr" or "[OTHER] values in uW / sr", or of photons, or
/// the file's own flux in such a unit: "[_RADIANTPOWER] 523 mW".  The unit is "unknown" if a
/// keyword about units has another value than candela, lumens or a length.  LM-63 has candela only
/// and no keyword for a unit; laboratories add their own.  Requires `file.web`.
void note_unit(std::string_view header, PhotometricFile& file);

}  // namespace lucerna
