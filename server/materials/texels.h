// The texels of a picture on surfaces, in the least memory that keeps their values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lights/pictures/image.h"
#include "lights/spectra/rgb.h"

namespace lucerna {

/// Rows from the top, as in Image.  Grey pictures have one channel.  Pictures with at most 256
/// different values, such as those of 8 bits, have a byte for each.  All others have floats.
class Texels {
 public:
  /// Keeps each value exactly.
  explicit Texels(const Image& image);

  int width() const { return width_; }
  int height() const { return height_; }
  /// 0 <= x < width(), 0 <= y < height().
  Rgb<double> texel(int x, int y) const {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x);
    if (is_grey_) return Rgb<double>(value(i));
    return {value(3 * i), value(3 * i + 1), value(3 * i + 2)};
  }
  std::size_t bytes() const {
    std::size_t sum = sizeof(*this) + codes_.capacity() +
                      wide_codes_.capacity() * sizeof wide_codes_[0] +
                      values_.capacity() * sizeof values_[0];
    for (const Texels& t : smaller_) sum += t.bytes();
    return sum;
  }

  /// The picture, and copies of it that are each half as wide and as high as the one before, down
  /// to one texel.
  std::size_t levels() const { return 1 + smaller_.size(); }
  const Texels& level(std::size_t i) const { return i == 0 ? *this : smaller_[i - 1]; }
  /// Makes the copies, unless they are there.
  void make_levels();

  /// Halves width and height; odd ones are rounded up.  Each texel becomes the mean of those that
  /// it covers.  Values are then 1/65535 of the largest one apart.  Requires more than one texel.
  void halve();

 private:
  double value(std::size_t i) const {
    if (!codes_.empty()) return values_[codes_[i]];
    if (!wide_codes_.empty()) return wide_codes_[i] * step_;
    return values_[i];
  }

  int width_, height_;
  bool is_grey_;
  std::vector<std::uint8_t> codes_;        ///< indices into `values_`
  std::vector<std::uint16_t> wide_codes_;  ///< in units of `step_`
  std::vector<float> values_;
  double step_ = 0;
  std::vector<Texels> smaller_;
};

}  // namespace lucerna
