// Pictures for lights: texels of linear RGB, and two ways to interpolate between them.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lights/maths/rgb.h"
#include "lights/maths/vec.h"

namespace lucerna {

/// How a picture is read between the centres of its texels.
enum class ImageFilter : std::uint8_t {
  kNearest,   ///< a texel's value everywhere in its square
  kBilinear,  ///< linear between the centres of texels; ImageBorder decides at the border
};

/// How a picture continues beyond its border.
enum class ImageBorder : std::uint8_t {
  kClamp,              ///< the border texels continue
  kLatitudeLongitude,  ///< left and right meet; a pole continues on the opposite meridian
  kOctahedral,         ///< each edge is folded at its middle: its two halves meet  [Clarberg08]
};

/// A texel by its column and row.
struct TexelIndex {
  int x, y;
  bool operator==(const TexelIndex&) const = default;
};

/// The place of a coordinate in [0, 1] between the centres of `n` texels.  It lies between the
/// centres of `first` (-1 before the first centre) and `first + 1`, at fraction `share`.
struct BetweenCentres {
  int first;
  double share;
};
BetweenCentres between_centres(double coordinate, int n);

/// The texel of a picture of `width` x `height` at (x, y).  Each coordinate may be outside of the
/// border by one.
TexelIndex at_border(ImageBorder border, int x, int y, int width, int height);

/// Rows from the top.  Texel (x, y) covers [x, x + 1) x [y, y + 1) / (width, height).  Immutable,
/// so lights share it.
class Image {
 public:
  /// Errors: no texels; a number of texels other than width times height; a texel that is negative
  /// or not finite, with its place in the message.
  static absl::StatusOr<std::shared_ptr<const Image>> create(int width, int height,
                                                             std::vector<Rgbf> texels);

  int width() const { return width_; }
  int height() const { return height_; }
  const Rgbf& texel(int x, int y) const {
    return texels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)];
  }
  /// All texels, rows from the top.
  std::span<const Rgbf> texels() const { return texels_; }
  /// The value at a point of the unit square, (0, 0) the upper left corner. Points outside count as
  /// the nearest point of its edge.
  Rgb lookup(Vec2 p, ImageFilter filter, ImageBorder border) const;
  /// The mean of `lookup` over the square.  It does not depend on filter and border, because every
  /// texel has the same weight.
  Rgb mean() const;
  /// The largest value of each channel.
  Rgb brightest() const;
  std::size_t bytes() const { return sizeof(*this) + texels_.capacity() * sizeof(Rgbf); }

 private:
  Image(int width, int height, std::vector<Rgbf> texels);
  int width_, height_;
  std::vector<Rgbf> texels_;
};

}  // namespace lucerna
