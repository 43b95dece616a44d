// What area lights have beyond their level.  Beyond what pbrt-v4 reads:
//   "string filter"  bilinear (pbrt-v4's) | nearest: how an emission image is read
//   "string profile" an .ies or .ldt file: a flat shape (rectangle, patches, triangles, disk) has
//                    this photometry as a whole.  Its normal is straight down from the luminaire,
//                    dp/du the plane C0 (of meshes that of their first primitive, of disks +x);
//                    "L" and "scale" multiply the file's candela, "power" is what leaves.
#pragma once

#include <optional>

#include "lights/models/panel.h"
#include "server/pbrt/images.h"
#include "server/pbrt/shapes.h"

namespace lucerna::pbrt {

/// The emission image of "string filename"; nothing where there is none.  Fails on "L" beside it.
std::optional<Picture> area_picture(Context& context, const ParameterSet& params);

/// The photometry of "string profile"; nothing where there is none.  Fails on an image beside it,
/// on files of other kinds and on shapes that are not flat.  `mirrored`: the transform of the shape
/// swaps handedness, and the photometry with it.
std::optional<PanelProfile> area_profile(Context& context, const ParameterSet& params,
                                         const Geometry& geometry, const Place& shape_place,
                                         bool mirrored);

/// Whether every texel of an emission image has the same area on the shape.
bool shows_texels_alike(const Geometry& geometry);

}  // namespace lucerna::pbrt
