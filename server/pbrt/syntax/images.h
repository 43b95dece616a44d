// Pictures that parameters name.
#pragma once

#include <memory>
#include <string>

#include "lights/pictures/image.h"
#include "server/formats/image_reader.h"
#include "server/pbrt/syntax/params.h"

namespace lucerna::pbrt {

/// A picture with the name that ListLights reports.
struct NamedImage {
  std::string name;  ///< relative to the scene root
  std::shared_ptr<const Image> image;
};

/// The picture that "string filename" (or such) names; those that name the same file share it.
/// Remarks and errors have the place of the parameter.
NamedImage read_image(Context& context, const Parameter& filename, Encoding encoding = kSrgb);

/// The same for the textures of the scene, whose memory has a limit.
std::shared_ptr<const Texels> read_texels(Context& context, const Parameter& filename,
                                          Encoding encoding);

/// The "string filter" of a light, nearest or bilinear.  `otherwise` applies if it is not given.
ImageFilter image_filter(const ParameterSet& params, const char* otherwise = "nearest");

}  // namespace lucerna::pbrt
