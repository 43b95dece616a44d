// The unit of intensity that the keywords of an IES LM-63 file state.
#pragma once

#include <string_view>

#include "server/formats/photometric_file.h"

namespace lucerna {

/// Sets `file.flux_unit` and `file.unit` if the lines before "TILT=" state a unit of radiant
/// intensity, such as "[_INTENSITYUNITS] mW/sr" or "[OTHER] values in uW / sr", or of photons.
/// LM-63 has candela only and no keyword for a unit; laboratories add their own.
void note_unit(std::string_view header, PhotometricFile& file);

}  // namespace lucerna
