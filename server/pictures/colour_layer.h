// The channels of a picture that hold its colours.  Only for the files of this room.
#pragma once

#include <OpenImageIO/imageio.h>

#include <array>
#include <optional>
#include <string>

namespace lucerna {

struct ColourLayer {
  std::string name;               ///< "diffuse" of the channels diffuse.R, diffuse.G, diffuse.B
  std::array<int, 3> channels{};  ///< of red, green and blue
  int alpha = -1;                 ///< -1: none
  int others = 0;                 ///< layers with colours besides this one
};

/// One or two channels are grey, and alpha.  Of more channels: R, G and B; else the first layer
/// that has them.  Nothing if none has.
std::optional<ColourLayer> colour_layer(const OIIO::ImageSpec& spec);

}  // namespace lucerna
