// The value of a picture at texture coordinates.
#pragma once

#include "lights/maths/rgb.h"
#include "server/materials/texture.h"

namespace lucerna {

/// How texture coordinates grow from one position on the film to the next, in x and in y.
struct CoordinateSteps {
  Vec2 x, y;
};

/// The value of the picture at `st`.  With `steps`, filters that use smaller copies of the picture
/// (kTrilinear, kEwa) take the mean over about this area.  Without, they are bilinear.  Black if
/// `st` is not finite.
Rgb look_up(const ImageTexture& texture, const Vec2& st, const CoordinateSteps* steps);

}  // namespace lucerna
