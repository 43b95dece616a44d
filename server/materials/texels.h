// The texels of a picture on surfaces, in the least memory that keeps their values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "lights/maths/rgb.h"
#include "lights/pictures/image.h"

namespace lucerna {

/// Rows from the top, as in Image.  Grey pictures have one channel.  Pictures with at most 256
/// different values, such as those of 8 bits, have a byte for each.  All others have floats.
class Texels {
 public:
  /// Keeps each value exactly.
  explicit Texels(const Image& image);
  /// A grey picture of these values.  Keeps each value exactly.
  static Texels grey(int width, int height, std::vector<float> values);
  /// A picture of codes, one for each texel if it is grey, else three.  A code is an index into
  /// `values`.
  Texels(int width, int height, bool is_grey, std::vector<std::uint8_t> codes,
         std::vector<float> values);

  int width() const { return width_; }
  int height() const { return height_; }
  /// 0 <= x < width(), 0 <= y < height().
  Rgb texel(int x, int y) const {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x);
    if (is_grey_) return Rgb(value(i));
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
  /// Makes the copies, unless they are there.  Makes none if `stop` is requested meanwhile.
  void make_levels(const std::stop_token& stop = {});

  /// Halves width and height; odd ones are rounded up.  Each texel becomes the mean of those that
  /// it covers.  Values are then 1/65535 of the largest one apart.  Requires more than one texel.
  /// Changes nothing if `stop` is requested meanwhile.
  void halve(const std::stop_token& stop = {});

 private:
  double value(std::size_t i) const {
    if (!codes_.empty()) return values_[codes_[i]];
    if (!wide_codes_.empty()) return wide_codes_[i] * step_;
    return values_[i];
  }
  /// Calls `f(mean)` for each texel of the halved picture, rows from the top.  Ends early if `stop`
  /// is requested.
  template <typename F>
  void for_each_mean(const std::stop_token& stop, F&& f) const;
  /// The halved picture; incomplete if `stop` is requested.  Requires that there are no levels.
  Texels halved(const std::stop_token& stop) const;

  int width_, height_;
  bool is_grey_;
  std::vector<std::uint8_t> codes_;        ///< indices into `values_`
  std::vector<std::uint16_t> wide_codes_;  ///< in units of `step_`
  std::vector<float> values_;
  double step_ = 0;
  std::vector<Texels> smaller_;
};

}  // namespace lucerna
