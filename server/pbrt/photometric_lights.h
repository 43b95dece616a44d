// Luminaires from photometric files.  Beyond what pbrt-v4 reads, "string filename" of a goniometric
// light may end in .ies (IES LM-63) or .ldt (EULUMDAT).  The luminaire's straight down is the +z of
// light space, its photometric horizontal (C0) the +x: untransformed it shines along +z, as a spot
// does and as the middle of pbrt-v4's goniometric picture.  Its candela are multiplied by "I" (1
// unless given) and "scale"; "power" sets its luminous flux.
#pragma once

#include <optional>
#include <string>

#include "server/pbrt/params.h"
#include "server/photometric_file.h"

namespace lucerna::pbrt {

/// Whether a name ends in .ies or .ldt, in letters of either case.
bool names_photometric_file(const std::string& name);

/// A photometric file with the name that ListLights tells.
struct NamedPhotometricFile {
  std::string name;  ///< relative to the scene root
  PhotometricFile file;
};

/// The luminaire in the file that a parameter names, once for all that name it.  Remarks and errors
/// stand at the parameter.
NamedPhotometricFile read_photometric_file(Context& context, const Parameter& filename);

/// LightSource "goniometric" but for its level: `intensity` is 1.  Nothing, and a remark, where
/// "filename" is a picture.  Fails on transforms of unequal scale.
std::optional<GoniometricLightParams> goniometric(Context& context, const ParameterSet& params,
                                                  const Place& place,
                                                  const Transform& world_from_light);

}  // namespace lucerna::pbrt
