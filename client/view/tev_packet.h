// What the viewer tev is told, message by message.  Not installed.
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

/// What is to be shown, as Picture has its pixels.
struct Canvas {
  struct Free {
    void operator()(float* p) const { std::free(p); }
  };
  std::uint32_t width = 0, height = 0;
  std::unique_ptr<float[], Free> pixels;

  Canvas() = default;
  /// Black; the system clears pages as they are written to, where to clear a large picture at once
  /// would hold up who begins it.
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

/// Opens the picture under a name, and makes it the one that is looked at.
std::string create_image(const std::string& name, const Canvas& picture);
/// The pixels of a rectangle, which must lie within the picture.
std::string update_image(const std::string& name, const Canvas& picture, const v1::PixelRect& rect);

}  // namespace lucerna::client
