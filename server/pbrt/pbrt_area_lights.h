// Converts AreaLightSource directives to the emission of shapes.  Parameters that pbrt-v4 does not
// have:
//   "string name"    the light's name, shared by all shapes of the directive
//   "string filter"  bilinear (pbrt-v4's) | nearest: how an emission image is read
//   "string profile" an .ies or .ldt file: a flat shape (rectangle, patches, triangles, disk) has
//                    this photometry as a whole.  Its normal is straight down from the luminaire
//                    and dp/du lies in the plane C0.  Meshes use dp/du of their first primitive,
//                    disks use +x.  "L" and "scale" multiply the file's candela; "power" is the
//                    flux that leaves the shape.  A picture multiplies the radiance.
#pragma once

#include <optional>
#include <string>

#include "server/pbrt/pbrt_images.h"
#include "server/pbrt/pbrt_shapes.h"

namespace lucerna::pbrt {

/// Whether the light needs the (u, v) of shapes, for an image or a profile.
bool needs_uv(const ParameterSet& light);

/// The emission of `geometry` with the AreaLightSource directive `light`.  Nothing, and a remark,
/// if the shape has no area. "power" is that of the whole mesh.  `mirrored`: the shape's transform
/// mirrors the shape and the photometry of a profile.  Fails on invalid levels, on shapes that
/// cannot emit, and on a profile for a shape that is not flat.
std::optional<ShapeDescription::Emission> make_emission(LoadState& context,
                                                        const ParameterSet& light,
                                                        const Geometry& geometry,
                                                        const FilePosition& shape_place,
                                                        bool mirrored);

}  // namespace lucerna::pbrt
