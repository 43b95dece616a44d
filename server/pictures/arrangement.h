// The place of stored texels in the picture.  Only for the files of this room.
#pragma once

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lights/maths/stop_poll.h"

namespace lucerna {

/// From the stored rows of a file to the rows of its picture, from the top.  The picture is turned
/// or mirrored as the file's orientation says.  It is as large as the file's display window, if
/// that counts.
class Arrangement {
 public:
  /// "Orientation" of `spec` is that of TIFF.  Without `has_display_window`, all stored texels are
  /// the picture.
  Arrangement(const OIIO::ImageSpec& spec, bool has_display_window);

  int width() const { return is_turned() ? display_height_ : display_width_; }
  int height() const { return is_turned() ? display_width_ : display_height_; }
  std::uint64_t texels() const {
    return static_cast<std::uint64_t>(width()) * static_cast<std::uint64_t>(height());
  }
  bool is_as_stored() const {
    return orientation_ == 1 && x_ == 0 && y_ == 0 && display_width_ == stored_width_ &&
           display_height_ == stored_height_;
  }

  /// The picture, of `each` values for each texel.  Texels that the file does not store are 0.
  template <typename Value>
  std::vector<Value> arranged(const std::vector<Value>& stored, std::size_t each) const;

 private:
  struct TexelPosition {
    std::int64_t x, y;
  };
  bool is_turned() const { return orientation_ >= 5; }
  /// The place in the stored rows, also outside of them.
  TexelPosition stored_place(int x, int y) const;

  int orientation_ = 1;
  int stored_width_, stored_height_, display_width_, display_height_;
  std::int64_t x_ = 0, y_ = 0;  ///< of the display window, from the first stored texel
};

template <typename Value>
std::vector<Value> Arrangement::arranged(const std::vector<Value>& stored, std::size_t each) const {
  std::vector<Value> result(texels() * each);
  auto to = result.begin();
  StopPoll poll;
  for (int y = 0; y < height(); ++y)
    for (int x = 0; x < width(); ++x, to += static_cast<std::ptrdiff_t>(each), poll()) {
      const TexelPosition from = stored_place(x, y);
      if (from.x < 0 || from.y < 0 || from.x >= stored_width_ || from.y >= stored_height_) continue;
      const auto texel = static_cast<std::size_t>(from.y * stored_width_ + from.x);
      for (std::size_t i = 0; i < each; ++i)
        to[static_cast<std::ptrdiff_t>(i)] = stored[texel * each + i];
    }
  return result;
}

}  // namespace lucerna
