// How different two pictures look when one is flipped with the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lucerna::tradeoff {

/// An observer 0.7 m before a screen of 0.7 m and 3840 pixels, as in [Andersson20]: pixels seen in
/// one degree.
inline constexpr double kPixelsPerDegree = 67.0206;

/// The difference of each pixel, in [0, 1], after [Andersson20]; their mean is what is told of a
/// picture.  `reference` and `test` hold width x height pixels of linear Rec. 709 RGB, interleaved,
/// rows from the top, each value clamped to [0, 1] first: what a screen shows of it.  Beyond the
/// edges the picture goes on as its outermost pixels.
std::vector<float> flip(std::span<const float> reference, std::span<const float> test,
                        std::uint32_t width, std::uint32_t height,
                        double pixels_per_degree = kPixelsPerDegree);

}  // namespace lucerna::tradeoff
