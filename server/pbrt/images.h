// Pictures that parameters name.
#pragma once

#include <memory>
#include <string>

#include "lights/pictures/image.h"
#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// A picture with the name that ListLights tells.
struct NamedImage {
  std::string name;  ///< relative to the scene root
  std::shared_ptr<const Image> image;
};

/// The picture that "string filename" (or such) names, once for all lights that name it.  Remarks
/// and errors stand at the parameter.
NamedImage read_image(Context& context, const Parameter& filename);

/// "string filter" of a light, nearest or bilinear; `otherwise`: as pbrt-v4 reads its picture.
ImageFilter image_filter(const ParameterSet& params, const char* otherwise = "nearest");

}  // namespace lucerna::pbrt
