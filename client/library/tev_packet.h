// The messages to the viewer tev.  This header is not installed.
//
// The protocol: tev's README and src/Ipc.cpp [github.com/Tom94/tev].
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <string>

#include "lucerna/v1/render.pb.h"

namespace lucerna::client {

/// The picture to show, with the pixels in the order of Picture.
struct Canvas {
  struct Free {
    void operator()(float* p) const { std::free(p); }
  };
  std::uint32_t width = 0, height = 0;
  std::unique_ptr<float[], Free> pixels;

  Canvas() = default;
  /// A black picture.  The system clears each page at its first use.  Clearing a large picture at
  /// once would delay the caller.
  Canvas(std::uint32_t w, std::uint32_t h)
      : width(w),
        height(h),
        pixels(static_cast<float*>(std::calloc(std::size_t{3} * w * h, sizeof(float)))) {
    if (!pixels) throw std::bad_alloc();
  }
  std::span<float> row(const v1::PixelRect& rect, std::size_t y) const {
    return {pixels.get() + 3 * (y * width + rect.x0()), std::size_t{3} * (rect.x1() - rect.x0())};
  }
};

/// Creates the picture under a name and selects it.
std::string create_image(const std::string& name, const Canvas& picture);
/// Sends the pixels of a rectangle, which must lie within the picture.
std::string update_image(const std::string& name, const Canvas& picture, const v1::PixelRect& rect);

}  // namespace lucerna::client
