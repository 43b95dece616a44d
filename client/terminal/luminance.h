// The luminance of linear RGB.
#pragma once

namespace lucerna::cli {

/// Luminance of Rec. 709 with D65, as the server computes it.  `rgb`: three values, any unit.
///
/// The Y row of the matrix of the Rec. 709 primaries and the D65 white point (0.3127, 0.3290).  It
/// has as many digits as in the server.  The usual four digits have an error of 2e-5, which the
/// trade-off study would count as an error of the setting.  [BT709]
template <typename Value>
double luminance(const Value* rgb) {
  return 0.2126390058715104 * rgb[0] + 0.7151686787677559 * rgb[1] + 0.0721923153607337 * rgb[2];
}

}  // namespace lucerna::cli
