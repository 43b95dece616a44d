// What the header of a picture says about its colours.  Only for the files of this room.
#pragma once

#include <OpenImageIO/imageio.h>

#include <optional>
#include <string>

#include "lights/maths/rgb_primaries.h"
#include "server/files/asset_reader.h"
#include "server/pictures/picture_format.h"

namespace lucerna {

/// The primaries that an OpenEXR or a Radiance file states, unless they are those of Rec. 709.
std::optional<RgbPrimaries> stated_primaries(const OIIO::ImageSpec& spec);

/// States the primaries X, Y and Z, and equal amounts as their white.
void set_primaries_of_xyz(OIIO::ImageSpec& spec);

/// The luminance of RGB (1, 1, 1) that an OpenEXR file states [cd/m2].  Nothing if it is not
/// stated, not positive or not finite.  [OpenEXR]
std::optional<double> stated_white_cd_m2(const OIIO::ImageSpec& spec);

/// What a file of integers states other than sRGB: a profile of the ICC, or the codes,
/// the gamma or the primaries of a PNG file.  Empty if there is nothing.
std::string other_colours(const AssetContent& content, PictureFormat format,
                          const OIIO::ImageSpec& spec);

}  // namespace lucerna
