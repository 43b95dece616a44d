// FLIP: the difference between two pictures that a viewer sees when flipping between them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lucerna::tradeoff {

/// Pixels in one degree, for an observer 0.7 m from a screen of 0.7 m width and 3840 pixels, as in
/// [Andersson20].
inline constexpr double kPixelsPerDegree = 67.0206;

/// The difference of each pixel, in [0, 1], after [Andersson20].  The error of a picture is the
/// mean over its pixels.  `reference` and `test` hold width x height pixels of linear Rec. 709 RGB,
/// interleaved, rows from the top.  Values are first clamped to [0, 1], the range of a screen.
/// Pixels beyond the edges equal the nearest pixel of the picture.
std::vector<float> flip(std::span<const float> reference, std::span<const float> test,
                        std::uint32_t width, std::uint32_t height,
                        double pixels_per_degree = kPixelsPerDegree);

}  // namespace lucerna::tradeoff
