// The pictures and the luminaire file of the cases.
#pragma once

#include "client/lab/conformance_cases.h"

namespace lucerna::conformance {

CaseFile sky();            ///< sky.pfm: 16 x 16 texels, smooth, with a brighter spot
CaseFile wide_sky();       ///< sky.pfm: 32 x 16 texels, the same for a latitude-longitude picture
CaseFile grey_sky();       ///< sky.pfm: 16 x 16 texels without colours
CaseFile wide_grey_sky();  ///< sky.pfm: 32 x 16 texels without colours
CaseFile bright_sky();     ///< sky.pfm: 16 x 16 texels of 1, and one of 1e6
CaseFile picture();        ///< picture.pfm: 6 x 4 texels of different colours, some of them black
CaseFile ies();            ///< lamp.ies: a luminaire that differs in four half-planes
CaseFile narrow_ies();     ///< lamp.ies: 1e6 cd downwards, and nothing beyond 1 degree

}  // namespace lucerna::conformance
