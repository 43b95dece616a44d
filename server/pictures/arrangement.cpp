#include "server/pictures/arrangement.h"

namespace lucerna {

Arrangement::Arrangement(const OIIO::ImageSpec& spec, bool has_display_window)
    : stored_width_(spec.width),
      stored_height_(spec.height),
      display_width_(has_display_window ? spec.full_width : spec.width),
      display_height_(has_display_window ? spec.full_height : spec.height) {
  const int orientation = spec.get_int_attribute("Orientation", 1);
  if (orientation >= 1 && orientation <= 8) orientation_ = orientation;
  if (!has_display_window) return;
  x_ = std::int64_t{spec.full_x} - spec.x;
  y_ = std::int64_t{spec.full_y} - spec.y;
}

Arrangement::TexelPosition Arrangement::stored_place(int x, int y) const {
  const int right = display_width_ - 1, bottom = display_height_ - 1;
  TexelPosition p{x, y};
  switch (orientation_) {
    case 2:
      p = {right - x, y};
      break;
    case 3:
      p = {right - x, bottom - y};
      break;
    case 4:
      p = {x, bottom - y};
      break;
    case 5:
      p = {y, x};
      break;
    case 6:
      p = {y, bottom - x};
      break;
    case 7:
      p = {right - y, bottom - x};
      break;
    case 8:
      p = {right - y, x};
      break;
    default:
      break;
  }
  return {p.x + x_, p.y + y_};
}

}  // namespace lucerna
