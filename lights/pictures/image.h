// Pictures that lights are made of: texels of linear RGB, and the two ways to look between them.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "lights/maths/vec.h"
#include "lights/spectra/rgb.h"

namespace lucerna {

/// How a picture is read between the centres of its texels.
enum class ImageFilter : std::uint8_t {
  kNearest,   ///< a texel's value all over its square
  kBilinear,  ///< linear between the centres of texels; at the border as the use of the image says
};

/// What lies beyond the border of a picture.
enum class ImageBorder : std::uint8_t {
  kClamp,              ///< the border goes on
  kLatitudeLongitude,  ///< left and right meet; beyond a pole lies the meridian half around
  kOctahedral,         ///< each edge is folded at its middle: its two halves meet  [Clarberg08]
};

/// A texel by its column and row.
struct TexelIndex {
  int x, y;
  bool operator==(const TexelIndex&) const = default;
};

/// Where a coordinate in [0, 1] falls among the centres of `n` texels: between those of `first` (-1
/// before the first centre) and `first + 1`, `share` of the way.
struct BetweenCentres {
  int first;
  double share;
};
BetweenCentres between_centres(double coordinate, int n);

/// The texel of a picture of `width` x `height` that stands at (x, y), which may lie one beyond the
/// border in each coordinate.
TexelIndex at_border(ImageBorder border, int x, int y, int width, int height);

/// Rows from the top; texel (x, y) covers [x, x + 1) x [y, y + 1) / (width, height).  Immutable,
/// and shared by the lights that use it.
class Image {
 public:
  /// Errors: no texels, a number of them that is not width times height, one that is negative or
  /// not finite, whose place the message says.
  static absl::StatusOr<std::shared_ptr<const Image>> create(int width, int height,
                                                             std::vector<Rgb<float>> texels);

  int width() const { return width_; }
  int height() const { return height_; }
  const Rgb<float>& texel(int x, int y) const {
    return texels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)];
  }
  /// The texel that stands at (x, y), which may lie one beyond the border.
  TexelIndex at_border(ImageBorder border, int x, int y) const {
    return lucerna::at_border(border, x, y, width_, height_);
  }
  /// At a point of the unit square, (0, 0) the upper left corner; points beyond it count as those
  /// of its edge.
  Rgb<double> lookup(Vec2<double> p, ImageFilter filter, ImageBorder border) const;
  /// The mean over the square of what `lookup` gives, whatever the filter and the border: each
  /// texel's share in it is the same.
  Rgb<double> mean() const;
  std::size_t bytes() const { return sizeof(*this) + texels_.capacity() * sizeof(Rgb<float>); }

 private:
  Image(int width, int height, std::vector<Rgb<float>> texels);
  int width_, height_;
  std::vector<Rgb<float>> texels_;
};

}  // namespace lucerna
