// Describes lights in words and lighting units.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <string>

#include "client/terminal/output.h"
#include "lucerna/v1/light.pb.h"

namespace lucerna::cli {

/// "spot", "sky image", ...
std::string type_of(const v1::Light& light);

/// Variant, size and level, then further properties: "half angle 30 deg, edge 5 deg, 1200 cd",
/// "rectangle 1.2 x 0.6 m, 4500 cd/m2, two-sided".  A coloured level is its luminance and its RGB.
std::string describe_light(const v1::Light& light);

/// Position and direction of the light [m]; for a light at infinity, the direction to it.
std::string place_of(const v1::Light& light);

/// Whether the light is a distant, sun or infinite light.  Its flux depends on the size of the
/// scene or of its portal.
bool is_at_infinity(const v1::Light& light);

/// Explains the mark on such a flux, without a full stop and without a new line.
inline constexpr char kFluxFromInfinity[] =
    "* light at infinity: the flux through the scene's bounding disk or the light's portal, not "
    "that of a luminaire";

/// A flux [lm], with a mark before it if it includes a light at infinity.
std::string flux_text(double lumens, bool from_infinity);

/// The same as a cell, whose value has no mark.
Cell flux_cell(double lumens, bool from_infinity);
/// The error of an exact power: "exact" for 0.
Cell error_cell(double lumens);

/// " [lm]", for the header of a column of fluxes; empty if any of `lights` is in another unit.  A
/// column "unit" then has flux_unit() of each.  `Light`: with a `power_unit`.
template <typename Light>
std::string lumens_header(const google::protobuf::RepeatedPtrField<Light>& lights) {
  for (const Light& light : lights)
    if (!light.power_unit().empty()) return "";
  return " [lm]";
}
/// The light's unit where it is not lm, otherwise "lm".
template <typename Light>
std::string flux_unit(const Light& light) {
  return light.power_unit().empty() ? "lm" : light.power_unit();
}

/// The table of `lucerna lights`, one row for each light.
Table light_table(const google::protobuf::RepeatedPtrField<v1::Light>& lights);
/// The explanation of its marks, with a new line.  Empty without marks.
std::string light_notes(const google::protobuf::RepeatedPtrField<v1::Light>& lights);

}  // namespace lucerna::cli
