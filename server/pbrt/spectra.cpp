#include "server/pbrt/spectra.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace lucerna::pbrt {
namespace {

constexpr int kFirstNm = 360;
constexpr int kLastNm = 830;

double lobe(double x, double peak, double below, double above) {
  const double t = (x - peak) / (x < peak ? below : above);
  return std::exp(-0.5 * t * t);
}

/// Linear RGB, Rec. 709 primaries and D65 white, of a colour in XYZ.  [BT709]
Rgb<double> rgb_from_xyz(const Vec3<double>& c) {
  return {3.2409699419045213 * c.x - 1.5373831775700935 * c.y - 0.4986107602930033 * c.z,
          -0.9692436362808798 * c.x + 1.8759675015077206 * c.y + 0.0415550574071756 * c.z,
          0.0556300796969936 * c.x - 0.2039769588889765 * c.y + 1.0569715142428786 * c.z};
}

template <typename F>
LightColour colour_of(F&& radiance) {
  Vec3<double> xyz{};
  for (int nm = kFirstNm; nm <= kLastNm; ++nm) xyz += colour_matching(nm) * radiance(nm);
  if (!(xyz.y > 0)) return {};
  const Rgb<double> raw = rgb_from_xyz(xyz / xyz.y);
  const Rgb<double> rgb{std::max(raw.r, 0.0), std::max(raw.g, 0.0), std::max(raw.b, 0.0)};
  return {rgb / luminance(rgb), rgb != raw};
}

/// Wavelengths and values of a spectrum parameter that holds numbers.  Fails where they are no
/// pairs, where wavelengths do not ascend and where a value is negative.
std::pair<std::vector<double>, std::vector<double>> samples(const Parameter& parameter) {
  const std::vector<double>& n = parameter.numbers;
  if (n.size() % 2 != 0)
    fail(parameter.place,
         fmt::format("spectrum \"{}\" has {} numbers, expected pairs of wavelength "
                     "and value",
                     parameter.name, n.size()));
  std::pair<std::vector<double>, std::vector<double>> result;
  for (std::size_t i = 0; i < n.size(); i += 2) {
    if (i > 0 && !(n[i] > n[i - 2]))
      fail(parameter.place,
           fmt::format("spectrum \"{}\": wavelength {} follows {}, they must ascend",
                       parameter.name, n[i], n[i - 2]));
    if (n[i + 1] < 0)
      fail(parameter.place, fmt::format("spectrum \"{}\" holds {}, allowed: not negative",
                                        parameter.name, n[i + 1]));
    result.first.push_back(n[i]);
    result.second.push_back(n[i + 1]);
  }
  return result;
}

double interpolate(std::span<const double> x, std::span<const double> y, double at) {
  if (x.empty() || at < x.front() || at > x.back()) return 0;
  const auto above = std::upper_bound(x.begin(), x.end(), at) - x.begin();
  if (above == static_cast<std::ptrdiff_t>(x.size())) return y.back();
  const double t = (at - x[above - 1]) / (x[above] - x[above - 1]);
  return std::lerp(y[above - 1], y[above], t);
}

Rgb<double> rgb_of(const Parameter& parameter) {
  if (parameter.numbers.size() != 3)
    fail(parameter.place, fmt::format("parameter \"{}\" has {} values, expected 3", parameter.name,
                                      parameter.numbers.size()));
  return {parameter.numbers[0], parameter.numbers[1], parameter.numbers[2]};
}

std::string text(const Rgb<double>& c) {
  return fmt::format("[{:.4g} {:.4g} {:.4g}]", c.r, c.g, c.b);
}

Rgb<double> taken_as(Context& context, const Parameter& parameter, const std::string& what,
                     const LightColour& colour) {
  context.remark(parameter.place, what + ": lights have no spectra yet",
                 fmt::format("linear RGB {} of luminance 1{}", text(colour.rgb),
                             colour.clipped ? ", clipped to what RGB can show" : ""));
  return colour.rgb;
}

}  // namespace

Vec3<double> colour_matching(double nm) {
  return {1.056 * lobe(nm, 599.8, 37.9, 31.0) + 0.362 * lobe(nm, 442.0, 16.0, 26.7) -
              0.065 * lobe(nm, 501.1, 20.4, 26.2),
          0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1),
          1.217 * lobe(nm, 437.0, 11.8, 36.0) + 0.681 * lobe(nm, 459.0, 26.0, 13.8)};
}

LightColour blackbody_colour(double kelvin) {
  // Planck's law in logarithms and relative to its value at the red end, which is the largest where
  // the values themselves would underflow (below 100 K).
  const auto log_radiance = [&](double nm) {
    constexpr double kSecondRadiationNmK = 1.438776877e7;
    const double x = kSecondRadiationNmK / (nm * kelvin);
    return -5 * std::log(nm) - x - std::log(-std::expm1(-x));
  };
  const double reference = log_radiance(kLastNm);
  return colour_of([&](double nm) { return std::exp(log_radiance(nm) - reference); });
}

LightColour spectrum_colour(std::span<const double> wavelengths_nm,
                            std::span<const double> values) {
  return colour_of([&](double nm) { return interpolate(wavelengths_nm, values, nm); });
}

Rgb<double> light_level(Context& context, const ParameterSet& params, std::string_view name) {
  const Parameter* parameter = params.find(name, {"rgb", "blackbody", "spectrum"});
  if (parameter == nullptr) return Rgb<double>(1);
  if (parameter->type == "rgb") {
    const Rgb<double> rgb = rgb_of(*parameter);
    if (std::min({rgb.r, rgb.g, rgb.b}) < 0)
      fail(parameter->place,
           fmt::format("\"rgb {}\" = {}, allowed: not negative", name, text(rgb)));
    return rgb;
  }
  if (parameter->type == "blackbody") {
    const double kelvin = parameter->numbers[0];
    if (parameter->numbers.size() != 1 || !(kelvin >= 100 && kelvin <= 1e7))
      fail(parameter->place, fmt::format("\"blackbody {}\" = {} K, allowed: one temperature in "
                                         "[100, 1e7] K",
                                         name, kelvin));
    return taken_as(context, *parameter, fmt::format("black body of {} K", kelvin),
                    blackbody_colour(kelvin));
  }
  if (!parameter->numbers.empty()) {
    const auto [wavelengths, values] = samples(*parameter);
    return taken_as(context, *parameter, fmt::format("spectrum \"{}\"", name),
                    spectrum_colour(wavelengths, values));
  }
  // pbrt-v4's name for the white of linear RGB.
  if (parameter->strings.front() == "stdillum-D65") return Rgb<double>(1);
  return taken_as(context, *parameter,
                  fmt::format("spectrum \"{}\"", printable(parameter->strings.front())),
                  {Rgb<double>(1)});
}

Rgb<double> reflectance(Context& context, const Parameter& parameter) {
  Rgb<double> rgb(0.5);
  if (parameter.type == "rgb") {
    rgb = rgb_of(parameter);
  } else if (parameter.type == "float") {
    rgb = Rgb<double>(parameter.numbers.front());
  } else if (parameter.type == "spectrum" && !parameter.numbers.empty()) {
    const auto [wavelengths, values] = samples(parameter);
    double y = 0, sum = 0;
    for (int nm = kFirstNm; nm <= kLastNm; ++nm) {
      y += colour_matching(nm).y * interpolate(wavelengths, values, nm);
      sum += colour_matching(nm).y;
    }
    rgb = Rgb<double>(y / sum);
    const bool constant =
        std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end() &&
        wavelengths.front() <= kFirstNm && wavelengths.back() >= kLastNm;
    if (constant) {
      rgb = Rgb<double>(values.front());
    } else {
      context.remark(parameter.place,
                     fmt::format("spectrum \"{}\" of a surface is not modelled", parameter.name),
                     fmt::format("grey {:.4g}, its luminous reflectance", rgb.r));
    }
  } else {
    context.remark(
        parameter.place,
        fmt::format("{} \"{}\" of a surface is not modelled", parameter.type, parameter.name),
        "grey 0.5");
  }
  const Rgb<double> clamped{std::clamp(rgb.r, 0.0, 1.0), std::clamp(rgb.g, 0.0, 1.0),
                            std::clamp(rgb.b, 0.0, 1.0)};
  if (clamped != rgb)
    context.remark(parameter.place,
                   fmt::format("\"{}\" = {} is no reflectance", parameter.name, text(rgb)),
                   fmt::format("clamped to {}", text(clamped)));
  return clamped;
}

}  // namespace lucerna::pbrt
