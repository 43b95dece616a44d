// Makes a picture from its texels.
#pragma once

#include <utility>
#include <vector>

#include "lights/shapes/shape_picture.h"

namespace lucerna::testing {

/// Rows from the top.
inline Picture grey(int width, int height, const std::vector<float>& values,
                    ImageFilter filter = ImageFilter::kNearest) {
  std::vector<Rgbf> texels;
  for (const float v : values) texels.emplace_back(v);
  return {*Image::create(width, height, std::move(texels)), filter, "grey"};
}

}  // namespace lucerna::testing
