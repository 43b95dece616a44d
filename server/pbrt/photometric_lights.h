// Goniometric lights.  The value of a texel of "string filename" (the mean of its channels), or 1
// without a file, is multiplied by "I" (default 1) and "scale"; "power" sets the luminous flux.
// Parameters that pbrt-v4 does not have:
//   "string mapping"   equalarea (pbrt-v4's: the middle of the picture is light space's +y, its
//                      right +x, its lower side +z) | latlong (pbrt-v2's: +y at the top, longitude
//                      to the right from +x by +z)
//   "string filter"    nearest (pbrt-v4's) | bilinear
//   "string filename"  may end in .ies (IES LM-63) or .ldt (EULUMDAT).  The luminaire's straight
//                      down is light space's +z, its photometric horizontal (C0) is +x:
//                      untransformed it shines along +z, like a spot.
#pragma once

#include <string>

#include "server/files/photometric_file.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// Whether a name ends in .ies or .ldt, in upper or lower case.
bool names_photometric_file(const std::string& name);

/// A photometric file with the name that ListLights reports.
struct NamedPhotometricFile {
  std::string name;  ///< relative to the scene root
  PhotometricFile file;
  std::string flux_unit;  ///< of the light; empty: lm
};

/// The luminaire in the file that a parameter names; parameters that name the same file share it.
/// Remarks and errors have the place of the parameter.  `params` are those of the light: if they
/// set its "power", its flux is in lm, whatever the file's unit.
NamedPhotometricFile read_photometric_file(LoadState& context, const ParameterSet& params,
                                           const Parameter& filename);

/// LightSource "goniometric" without its level: `intensity` is 1.  Fails on a picture that the
/// mapping cannot use.
GoniometricLightParams goniometric(LoadState& context, const ParameterSet& params,
                                   const Transform& world_from_light);

}  // namespace lucerna::pbrt
