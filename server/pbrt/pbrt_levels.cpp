#include "server/pbrt/pbrt_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/pbrt/pbrt_spectra.h"

namespace lucerna::pbrt {
namespace {

/// Scales `level` so that a level of luminance 1 would reach the target in `given`.
Rgb scaled_to_target(LoadState& context, const Parameter& given, const LevelTarget& target,
                     double wanted, const Rgb& level) {
  if (!(luminance(level) > 0))
    fail(given.place, fmt::format("\"float {}\" = {} {} for a light of luminance 0{}", target.name,
                                  wanted, target.unit, kOnlyAsIfNotGiven));
  if (!(target.of_unit_level > 0))
    fail(given.place, fmt::format("\"float {}\" = {} {} for a light that illuminates nothing{}",
                                  target.name, wanted, target.unit, kOnlyAsIfNotGiven));
  // Files give levels with four or five digits, so a luminance this close to 1 counts as 1.
  if (std::fabs(luminance(level) - 1) > 1e-4)
    context.remark(
        given.place,
        fmt::format("\"{}\" {} {} multiplies a level of luminance {:.6g}", target.name, wanted,
                    target.unit, luminance(level)),
        fmt::format("{:.6g} {}, the same as in pbrt-v4", wanted * luminance(level), target.unit));
  return level * (wanted / target.of_unit_level);
}

}  // namespace

double level_scale(const ParameterSet& params) {
  return params.number(
      "scale", 1, [](double scale) { return !(scale < 0); }, ", allowed: not negative");
}

double target_of(LoadState& context, const ParameterSet& params, const char* name,
                 const std::string& instead) {
  const Parameter* given = params.find(name, {"float"});
  if (given == nullptr) return 0;
  // pbrt-v4 uses -1 for "not given".
  const double wanted = params.number(
      name, 0, [](double w) { return !(w < 0 && w != -1); }, ", allowed: not negative");
  if (wanted == 0)
    context.remark(given->place, fmt::format("\"{}\" 0 is taken as not given", name), instead);
  return std::max(wanted, 0.0);
}

Rgb light_level_with_target(LoadState& context, const ParameterSet& params, const char* name,
                            const LevelTarget& target) {
  const Rgb colour = light_level(context, params, name);
  Rgb result = colour * level_scale(params);
  const double wanted =
      target_of(context, params, target.name, fmt::format("the level of \"{}\"", name));
  const Parameter* given = params.find(target.name, {"float"});
  if (wanted > 0) result = scaled_to_target(context, *given, target, wanted, result);
  require_level(level_place(params, name),
                fmt::format("the light's level, \"{}\" times \"scale\"{}", name,
                            given ? fmt::format(" and the factor for \"{}\"", given->name) : ""),
                result);
  return result;
}

const Parameter* positive_parameter(const ParameterSet& params, std::string_view name) {
  const Parameter* given = params.find(name, {"float"});
  return given != nullptr && given->numbers().front() > 0 ? given : nullptr;
}

FilePosition level_place(const ParameterSet& params, std::string_view name) {
  return params.place_of({"scale", "power", "illuminance", name, "filename"});
}

void require_level(const FilePosition& place, std::string_view what, const Rgb& value) {
  if (is_finite(Rgbf(value))) return;
  fail(place,
       fmt::format("{} = ({:.6g}, {:.6g}, {:.6g}), allowed: each channel finite, at most "
                   "{:.3g}",
                   what, value.r, value.g, value.b, double{std::numeric_limits<float>::max()}));
}

}  // namespace lucerna::pbrt
