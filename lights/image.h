// Pictures that lights are made of: texels of linear RGB, and the two ways to look between them.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <vector>

#include "lights/rgb.h"
#include "lights/vec.h"

namespace lucerna {

/// How a picture is read between the centres of its texels.
enum class ImageFilter : std::uint8_t {
  kNearest,   ///< a texel's value all over its square
  kBilinear,  ///< linear between the centres of texels; at the border as the use of the image says
};

/// Rows from the top; texel (x, y) covers [x, x + 1) x [y, y + 1) / (width, height).  Immutable,
/// and shared by the lights that use it.
class Image {
 public:
  /// Errors: no texels, a number of them that is not width times height, one that is negative or
  /// not finite.
  static absl::StatusOr<std::shared_ptr<const Image>> create(int width, int height,
                                                             std::vector<Rgb<float>> texels);

  int width() const { return width_; }
  int height() const { return height_; }
  const Rgb<float>& texel(int x, int y) const {
    return texels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)];
  }
  std::size_t bytes() const { return sizeof(*this) + texels_.capacity() * sizeof(Rgb<float>); }

 private:
  Image(int width, int height, std::vector<Rgb<float>> texels);
  int width_, height_;
  std::vector<Rgb<float>> texels_;
};

}  // namespace lucerna
