#include "server/pbrt/pbrt_spectra.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "server/files/printable.h"
#include "server/pbrt/older_pbrt.h"

namespace lucerna::pbrt {
namespace {

/// Samples from pairs of wavelength and value.  Fails if the numbers do not form such pairs.
SampledSpectrum samples(const FilePosition& place, const std::string& what,
                        const std::vector<double>& numbers) {
  if (numbers.size() % 2 != 0)
    fail(place, fmt::format("{} has {} numbers, expected pairs of wavelength and value", what,
                            numbers.size()));
  SampledSpectrum result;
  StopPoll poll;
  for (std::size_t i = 0; i < numbers.size(); i += 2, poll()) {
    result.wavelengths_nm.push_back(numbers[i]);
    result.values.push_back(numbers[i + 1]);
  }
  if (const absl::Status status = check_samples(result); !status.ok())
    fail(place, fmt::format("{}: {}", what, std::string(status.message())));
  return result;
}

/// The numbers of a text file; # begins a comment.
std::vector<double> numbers_of(const FilePosition& place, const AssetContent& file) {
  std::vector<double> numbers;
  std::string_view rest = without_byte_order_mark(file.bytes);
  for (int line = 1; !rest.empty(); ++line) {
    const std::size_t end = rest.find('\n');
    std::string_view text = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    text = text.substr(0, text.find('#'));
    constexpr std::string_view kBlank = " \t\r\f\v,";
    while ((text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size())),
            !text.empty())) {
      const std::string_view word = text.substr(0, text.find_first_of(kBlank));
      const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
      double value = 0;
      const auto [stop, error] =
          std::from_chars(digits.data(), digits.data() + digits.size(), value);
      if (error != std::errc() || stop != digits.data() + digits.size() || !std::isfinite(value))
        fail(place, fmt::format("{}:{}: \"{}\", expected a finite number", printable(file.name),
                                line, printable(std::string(word))));
      numbers.push_back(value);
      text.remove_prefix(word.size());
    }
  }
  return numbers;
}

template <typename Source>
Spectrum made(const FilePosition& place, const std::string& what, Source source) {
  absl::StatusOr<Spectrum> spectrum = Spectrum::create(std::move(source));
  if (!spectrum.ok())
    fail(place, fmt::format("{}: {}", what, std::string(spectrum.status().message())));
  return *std::move(spectrum);
}

/// Whether pbrt-v4 uses the name for a spectrum that is not a light's.
bool of_no_light(const std::string& name) {
  return name.starts_with("metal-") || name.starts_with("glass-") || name.starts_with("canon_") ||
         name.starts_with("nikon_") || name.starts_with("sony_");
}

/// The colour of a surface under D65.
Rgb colour_of(const SampledSpectrum& reflectance) {
  const auto& [nm, values] = reflectance;
  // The integral of a constant would give it to rounding.
  return is_constant(reflectance) && nm.front() <= 360 && nm.back() >= 830
             ? Rgb(values.front())
             : reflected_rgb(nm, values);
}

/// A key for sharing spectra: the content if it is short, else the place in the file.
std::string key_of(const Parameter& p) {
  if (p.type == "blackbody") return fmt::format("blackbody {}", p.numbers().front());
  if (!p.strings().empty() && p.strings().front().starts_with("stdillum-"))
    return p.strings().front();
  const SourceLocation at = location(p.place);
  return fmt::format("{}:{}:{}", at.file.str(), at.line, at.column);
}

std::shared_ptr<const Spectrum> read_spectrum(LoadState& context, const Parameter& p) {
  if (p.type == "blackbody") {
    if (p.numbers().size() != 1)
      fail(p.place,
           fmt::format("\"blackbody {}\" has {} values, allowed: one temperature in "
                       "[100, 1e7] K{}",
                       p.name, p.numbers().size(), p.numbers().size() == 2 ? kIsOfPbrt3 : ""));
    return std::make_shared<Spectrum>(
        made(p.place, fmt::format("\"blackbody {}\"", p.name), BlackBody{p.numbers().front()}));
  }
  const std::string what = fmt::format("spectrum \"{}\"", p.name);
  if (!p.strings().empty()) {
    const std::string& name = p.strings().front();
    constexpr std::string_view kIlluminant = "stdillum-";
    if (name.starts_with(kIlluminant))
      return std::make_shared<Spectrum>(
          made(p.place, what, CieIlluminant{printable(name.substr(kIlluminant.size()))}));
    if (of_no_light(name)) {
      context.remark(p.place,
                     fmt::format("{} \"{}\" is not the spectrum of a light", what, printable(name)),
                     "linear RGB [1 1 1]");
      return nullptr;
    }
  }
  absl::StatusOr<Spectrum> spectrum = Spectrum::create(spectrum_samples(context, p));
  if (absl::IsFailedPrecondition(spectrum.status())) {
    context.remark(p.place, fmt::format("{}: {}", what, std::string(spectrum.status().message())),
                   "black");
    return nullptr;
  }
  return std::make_shared<Spectrum>(*std::move(spectrum));
}

/// The spectrum, read once for all lights that share it.  Null for parameters without a spectrum.
std::shared_ptr<const Spectrum> spectrum_of(LoadState& context, const Parameter* parameter) {
  if (parameter == nullptr || parameter->type == "rgb") return nullptr;
  const auto [entry, is_new] = context.spectra.try_emplace(key_of(*parameter));
  if (is_new) entry->second = read_spectrum(context, *parameter);
  return entry->second;
}

/// As not_negative_rgb, with negative values.
Rgb linear_rgb(LoadState& context, const Parameter& parameter, RgbConversion::White white) {
  if (parameter.numbers().size() != 3)
    fail(parameter.place, fmt::format("parameter \"{}\" has {} values, expected 3", parameter.name,
                                      parameter.numbers().size()));
  const Rgb given{parameter.numbers()[0], parameter.numbers()[1], parameter.numbers()[2]};
  if (parameter.primaries == nullptr) return given;
  const Rgb rgb = (*RgbConversion::to_rec709(*parameter.primaries, white))(given);
  const Rgb edge = at_edge_of_rec709(rgb);
  if (is_outside_rec709(rgb))
    context.remark(
        parameter.place,
        fmt::format("\"rgb {}\" = {} is outside of Rec. 709", parameter.name, text(given)),
        fmt::format("linear RGB {} of the same luminance", text(edge)));
  return edge;
}

}  // namespace

Rgb not_negative_rgb(LoadState& context, const Parameter& parameter, RgbConversion::White white) {
  const Rgb rgb = linear_rgb(context, parameter, white);
  if (std::ranges::min(parameter.numbers()) < 0)
    fail(parameter.place, fmt::format("\"rgb {}\" = [{:.4g}], allowed: not negative",
                                      parameter.name, fmt::join(parameter.numbers(), " ")));
  return rgb;
}

std::shared_ptr<const Spectrum> light_spectrum(LoadState& context, const ParameterSet& params,
                                               std::string_view name) {
  const Parameter* parameter = params.find(name, {"rgb", "blackbody", "spectrum"});
  const std::shared_ptr<const Spectrum> spectrum = spectrum_of(context, parameter);
  if (spectrum != nullptr && spectrum->clipped())
    context.remark(parameter->place,
                   fmt::format("{} \"{}\" is outside of the RGB gamut", parameter->type, name),
                   fmt::format("linear RGB {} of luminance 1; queries by wavelength are exact",
                               text(spectrum->rgb())));
  return spectrum;
}

void remark_on_spectrum_of_picture(LoadState& context, const ParameterSet& params,
                                   std::string_view name) {
  const Parameter* parameter = params.find(name, {"rgb", "blackbody", "spectrum"});
  if (const auto spectrum = spectrum_of(context, parameter))
    context.remark(
        parameter->place,
        fmt::format("{} \"{}\" of a light with a picture, whose colours are RGB", parameter->type,
                    name),
        fmt::format("the spectrum becomes RGB {} of luminance 1, also for queries by wavelength",
                    text(spectrum->rgb())));
}

Rgb light_level(LoadState& context, const ParameterSet& params, std::string_view name) {
  const Parameter* parameter = params.find(name, {"rgb", "blackbody", "spectrum"});
  if (parameter == nullptr) return Rgb(1);
  if (parameter->type == "rgb")
    return not_negative_rgb(context, *parameter, RgbConversion::White::kKept);
  if (const auto spectrum = spectrum_of(context, parameter)) return spectrum->rgb();
  const bool named = parameter->numbers().empty() && of_no_light(parameter->strings().front());
  return Rgb(named ? 1 : 0);
}

SampledSpectrum spectrum_samples(LoadState& context, const Parameter& parameter) {
  const std::string what = fmt::format("spectrum \"{}\"", parameter.name);
  if (!parameter.numbers().empty()) return samples(parameter.place, what, parameter.numbers());
  const std::vector<double> numbers = numbers_of(parameter.place, context.read(parameter));
  if (numbers.empty())
    fail(parameter.place,
         fmt::format("\"{}\" holds no numbers", printable(parameter.strings().front())));
  return samples(parameter.place, what, numbers);
}

bool is_constant(const SampledSpectrum& spectrum) {
  return std::ranges::adjacent_find(spectrum.values, std::not_equal_to<>()) ==
         spectrum.values.end();
}

Rgb clamped_reflectance(LoadState& context, const FilePosition& place, const std::string& what,
                        const Rgb& rgb) {
  const Rgb clamped{std::clamp(rgb.r, 0.0, 1.0), std::clamp(rgb.g, 0.0, 1.0),
                    std::clamp(rgb.b, 0.0, 1.0)};
  if (clamped != rgb)
    context.remark(place, fmt::format("{}{} is not a valid reflectance", what, text(rgb)),
                   fmt::format("clamped to {}", text(clamped)));
  return clamped;
}

Rgb reflectance(LoadState& context, const Parameter& parameter) {
  Rgb rgb(0.5);
  if (parameter.type == "rgb") {
    rgb = linear_rgb(context, parameter, RgbConversion::White::kAdapted);
  } else if (parameter.type == "float") {
    rgb = Rgb(parameter.numbers().front());
  } else if (!parameter.strings().empty() &&
             (of_no_light(parameter.strings().front()) ||
              parameter.strings().front().starts_with("stdillum-"))) {
    context.remark(parameter.place,
                   fmt::format("\"{}\" is not the spectrum of a reflectance",
                               printable(parameter.strings().front())),
                   "grey 0.5");
  } else {
    rgb = colour_of(spectrum_samples(context, parameter));
  }
  const char* of_spectrum = parameter.type == "spectrum" ? "the colour of " : "";
  return clamped_reflectance(context, parameter.place,
                             fmt::format("{}\"{}\" = ", of_spectrum, parameter.name), rgb);
}

std::string text(const Rgb& c) { return fmt::format("[{:.4g} {:.4g} {:.4g}]", c.r, c.g, c.b); }

}  // namespace lucerna::pbrt
