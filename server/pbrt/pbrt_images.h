// Pictures that parameters name.
#pragma once

#include <memory>
#include <string>

#include "lights/pictures/image.h"
#include "server/files/image_reader.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// A picture with the name that ListLights reports.
struct NamedImage {
  std::string name;  ///< relative to the scene root
  std::shared_ptr<const Image> image;
};

/// Thrown after a remark, for a light whose picture cannot be decoded.  No level that one could
/// invent is that of the light, so the scene does without it.
struct LightLeftOut {};

/// The picture of a light that "string filename" (or such) names; lights that name the same file
/// share it.  Remarks and errors have the place of the parameter.  Throws LightLeftOut.
NamedImage read_image(LoadState& context, const Parameter& filename, Encoding encoding);

/// The same for the textures of the scene, whose memory has a limit.  Null for a picture that
/// cannot be decoded, after a remark that says what happens `instead`.
std::shared_ptr<const Texels> read_texels(LoadState& context, const Parameter& filename,
                                          Encoding encoding, const char* instead);

/// The "string filter" of a light, nearest or bilinear.  `otherwise` applies if it is not given.
ImageFilter image_filter(const ParameterSet& params, const char* otherwise = "nearest");

}  // namespace lucerna::pbrt
