// What a light is, in words and lighting units.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <string>

#include "lucerna/v1/light.pb.h"

namespace lucerna::cli {

/// "spot", "sky image", ...
std::string type_of(const v1::Light& light);

/// Variant, size and level, then what is special: "half angle 30 deg, edge 5 deg, 1200 cd",
/// "rectangle 1.2 x 0.6 m, 4500 cd/m2, two-sided".  Coloured levels are told by their luminance,
/// with their RGB.
std::string describe(const v1::Light& light);

/// Where it stands and what it points at [m]; where it fills the sky, from where it shines.
std::string place_of(const v1::Light& light);

/// The table that `lucerna lights` prints, one row a light.
std::string light_table(const google::protobuf::RepeatedPtrField<v1::Light>& lights);

}  // namespace lucerna::cli
