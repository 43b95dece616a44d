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
std::string describe_light(const v1::Light& light);

/// Where it stands and what it points at [m]; where it fills the sky, from where it shines.
std::string place_of(const v1::Light& light);

/// Distant, sun and infinite lights: they have no flux of their own, and what is told as theirs
/// depends on the scene's size or the portal's.
bool is_at_infinity(const v1::Light& light);

/// What the mark on such a light's flux means; no full stop and no new line.
inline constexpr char kFluxFromInfinity[] =
    "* of a light at infinity: what goes through the scene's bounding disk, or through the light's "
    "portal, and no luminaire's flux";

/// A flux [lm], with a mark before it where it is or includes one of a light at infinity.
std::string flux_text(double lumens, bool from_infinity);

/// The table that `lucerna lights` prints, one row a light, and what its marks mean.
std::string light_table(const google::protobuf::RepeatedPtrField<v1::Light>& lights);

}  // namespace lucerna::cli
