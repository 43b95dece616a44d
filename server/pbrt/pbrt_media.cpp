#include "server/pbrt/pbrt_media.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/pbrt/metals.h"
#include "server/pbrt/pbrt_spectra.h"

namespace lucerna::pbrt {
namespace {

/// pbrt-v4's coefficients of a medium that does not give them [1/m].
constexpr Rgb kDefaultAbsorption{.0011, .0024, .014};

/// An absorption or scattering coefficient [1/m], before the medium's scale.  Nothing if it is not
/// given.
std::optional<Rgb> coefficient(LoadState& context, const ParameterSet& params, const char* name) {
  const Parameter* p = params.find(name, {"rgb", "spectrum"});
  if (p == nullptr) return std::nullopt;
  if (p->type == "rgb") return not_negative_rgb(context, *p, RgbConversion::White::kAdapted);
  const SampledSpectrum samples = spectrum_samples(context, *p);
  if (is_constant(samples)) return Rgb(samples.values.front());
  const Rgb c = under_d65(samples);
  // Colours out of the gamut.
  return Rgb(std::fmax(c.r, 0), std::fmax(c.g, 0), std::fmax(c.b, 0));
}

Medium homogeneous(LoadState& context, const std::string& owner, const ParameterSet& params) {
  if (const Parameter* preset = params.find("preset", {"string"})) {
    context.remark(preset->place, fmt::format("the preset of {} is not modelled", owner),
                   "no absorption");
    return {};
  }
  const double scale = params.number(
      "scale", 1, [](double s) { return s >= 0; }, ", allowed: at least 0");
  const auto scattering = coefficient(context, params, "sigma_s");
  if (scale > 0 && (!scattering || !scattering->is_black()))
    context.remark(params.place_of({"sigma_s"}),
                   fmt::format("scattering within {} is not modelled", owner), "absorption only");
  if (const Parameter* emission = params.find("Le", {"rgb", "spectrum", "blackbody"}))
    context.remark(emission->place, fmt::format("emission of {} is not modelled", owner),
                   "absorption only");
  params.ignore({"g", "Lescale"});
  return {coefficient(context, params, "sigma_a").value_or(kDefaultAbsorption) * scale};
}

}  // namespace

Media::Entry& Media::entry(LoadState& context, const std::string& name, const FilePosition& place) {
  auto& media = context.scene.media;
  const auto [it, added] =
      media_.try_emplace(name, Entry{static_cast<std::int32_t>(media.size()), place});
  if (added) media.emplace_back();
  return it->second;
}

void Media::make(LoadState& context, const std::string& name, const ParameterSet& params) {
  const FilePosition& place = params.place();
  Entry& medium = entry(context, name, place);
  if (medium.defined)
    fail(place, fmt::format("medium \"{}\" is already defined, at {}", printable(name),
                            to_string(medium.place)));
  medium.place = place;
  medium.defined = true;
  const std::string owner = fmt::format("medium \"{}\"", printable(name));
  const std::string type = params.string("type", "");
  if (type == "homogeneous") {
    context.scene.media[static_cast<std::size_t>(medium.number)] =
        homogeneous(context, owner, params);
    params.remark_unused(context, owner);
  } else if (is_one_of(type, {"uniformgrid", "rgbgrid", "nanovdb", "cloud"})) {
    context.remark(place, fmt::format("{} of type \"{}\" is not modelled", owner, type),
                   "no absorption");
  } else {
    fail(params.place_of({"type"}),
         fmt::format("\"string type\" = \"{}\" of {}, allowed: homogeneous uniformgrid rgbgrid "
                     "nanovdb cloud",
                     printable(type), owner));
  }
}

std::int32_t Media::named(LoadState& context, const std::string& name, const FilePosition& place) {
  return name.empty() ? -1 : entry(context, name, place).number;
}

void Media::finish() const {
  for (const auto& [name, medium] : media_)
    if (!medium.defined)
      fail(medium.place,
           fmt::format("medium \"{}\" is not defined in this scene", printable(name)));
}

}  // namespace lucerna::pbrt
