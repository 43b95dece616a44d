#include "server/pbrt/levels.h"

#include <fmt/format.h>

#include <limits>

namespace lucerna::pbrt {

Place level_place(const ParameterSet& params, std::string_view name, const Place& directive) {
  return params.place_of({"scale", "power", "illuminance", name, "filename"}, directive);
}

void require_level(const Place& place, std::string_view what, const Rgb<double>& value) {
  if (is_finite(Rgb<float>(value))) return;
  fail(place,
       fmt::format("{} = ({:.6g}, {:.6g}, {:.6g}), allowed: each channel finite, at most "
                   "{:.3g}",
                   what, value.r, value.g, value.b, double{std::numeric_limits<float>::max()}));
}

}  // namespace lucerna::pbrt
