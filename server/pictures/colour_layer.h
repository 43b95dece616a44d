// The channels of a picture that hold its colours.  Only for the files of this room.
#pragma once

#include <OpenImageIO/imageio.h>

#include <array>
#include <optional>
#include <string>

namespace lucerna {

struct ColourLayer {
  std::string name{};             ///< "diffuse" of the channels diffuse.R, diffuse.G, diffuse.B
  std::array<int, 3> channels{};  ///< of red, green and blue, or of X, Y and Z; equal if grey
  int alpha = -1;                 ///< -1: none
  int others = 0;                 ///< layers with colours besides this one
  bool is_xyz = false;

  bool is_grey() const { return channels[0] == channels[1]; }
};

/// R, G and B; else the first layer that has them; else X, Y and Z; else a single channel besides
/// alpha and depth is grey.  Nothing if there are none.
///
/// OpenEXR files name their channels, with `are_named`.  In other files, the first of one or two
/// channels is grey.
std::optional<ColourLayer> colour_layer(const OIIO::ImageSpec& spec, bool are_named);

}  // namespace lucerna
