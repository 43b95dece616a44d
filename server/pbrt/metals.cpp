#include "server/pbrt/metals.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "lights/maths/cie.h"
#include "server/pbrt/pbrt_spectra.h"

namespace lucerna::pbrt {
namespace {

/// At 360, 370, ..., 830 nm.
constexpr std::size_t kSize = 48;
struct Metal {
  std::string_view name;
  std::array<double, kSize> eta, k;
};

constexpr std::array<Metal, 6> kMetals{{
    {"Ag",
     {0.1938, 0.1919, 0.1986, 0.1879, 0.173,  0.1728, 0.1669, 0.1595, 0.1575, 0.1517,
      0.1434, 0.1361, 0.1314, 0.1302, 0.13,   0.13,   0.13,   0.1298, 0.1286, 0.1248,
      0.1212, 0.1197, 0.1197, 0.121,  0.124,  0.1274, 0.131,  0.1342, 0.1371, 0.1394,
      0.14,   0.1401, 0.14,   0.1403, 0.1425, 0.1446, 0.1464, 0.1479, 0.147,  0.146,
      0.1448, 0.1436, 0.1429, 0.1427, 0.1426, 0.1435, 0.1444, 0.1458},
     {1.543, 1.641, 1.718, 1.838, 1.951, 2.071, 2.183, 2.283, 2.375, 2.47,  2.567, 2.659,
      2.746, 2.83,  2.918, 3.01,  3.098, 3.178, 3.258, 3.34,  3.421, 3.501, 3.58,  3.657,
      3.731, 3.805, 3.881, 3.963, 4.045, 4.129, 4.21,  4.292, 4.371, 4.449, 4.523, 4.597,
      4.671, 4.745, 4.821, 4.897, 4.975, 5.052, 5.131, 5.21,  5.29,  5.369, 5.448, 5.527}},
    {"Al",
     {0.3971, 0.4189, 0.4422, 0.4661, 0.4901, 0.5149, 0.5394, 0.5644, 0.5905, 0.618, 0.6463, 0.6749,
      0.7046, 0.7359, 0.7686, 0.8028, 0.8387, 0.8764, 0.916,  0.9586, 1.004,  1.049, 1.097,  1.148,
      1.197,  1.248,  1.3,    1.357,  1.415,  1.475,  1.536,  1.599,  1.674,  1.75,  1.837,  1.927,
      2.037,  2.148,  2.27,   2.393,  2.49,   2.584,  2.665,  2.733,  2.8,    2.777, 2.755,  2.721},
     {4.373, 4.493, 4.615, 4.741, 4.861, 4.98,  5.105, 5.23,  5.348, 5.469, 5.59,  5.716,
      5.839, 5.96,  6.078, 6.199, 6.323, 6.447, 6.562, 6.687, 6.807, 6.924, 7.036, 7.146,
      7.257, 7.368, 7.481, 7.588, 7.693, 7.794, 7.9,   8.008, 8.115, 8.221, 8.312, 8.403,
      8.49,  8.572, 8.594, 8.617, 8.613, 8.604, 8.569, 8.509, 8.449, 8.397, 8.344, 8.298}},
    {"Au",
     {1.726,  1.706,  1.688,  1.671,  1.658,  1.641,  1.628,  1.61,   1.574,  1.508,
      1.419,  1.321,  1.19,   1.02,   0.8512, 0.6997, 0.572,  0.4729, 0.3976, 0.3504,
      0.3172, 0.2872, 0.26,   0.2369, 0.2203, 0.2061, 0.1939, 0.1837, 0.1748, 0.1678,
      0.1639, 0.1611, 0.1605, 0.1601, 0.1605, 0.1611, 0.1626, 0.1642, 0.1667, 0.1691,
      0.1719, 0.1746, 0.1771, 0.1792, 0.1814, 0.1839, 0.1864, 0.1892},
     {1.854, 1.883, 1.918, 1.941, 1.956, 1.959, 1.952, 1.935, 1.911, 1.879, 1.843, 1.81,
      1.796, 1.814, 1.887, 2.018, 2.184, 2.371, 2.555, 2.714, 2.837, 2.91,  2.948, 2.969,
      3,     3.03,  3.06,  3.066, 3.09,  3.138, 3.275, 3.443, 3.633, 3.818, 3.964, 4.107,
      4.237, 4.365, 4.479, 4.594, 4.701, 4.808, 4.914, 5.021, 5.127, 5.226, 5.325, 5.419}},
    {"Cr",
     {1.377, 1.421, 1.436, 1.458, 1.498, 1.546, 1.617, 1.71,  1.82,  1.928, 2.052, 2.199,
      2.345, 2.489, 2.606, 2.723, 2.839, 2.956, 3.04,  3.116, 3.19,  3.258, 3.326, 3.379,
      3.428, 3.476, 3.517, 3.557, 3.597, 3.638, 3.678, 3.718, 3.758, 3.798, 3.838, 3.872,
      3.906, 3.94,  3.974, 4.008, 4.042, 4.075, 4.109, 4.143, 4.177, 4.211, 4.246, 4.276},
     {3.227, 3.293, 3.364, 3.463, 3.591, 3.72,  3.836, 3.958, 4.077, 4.168, 4.258, 4.347,
      4.397, 4.44,  4.449, 4.458, 4.456, 4.451, 4.438, 4.423, 4.408, 4.395, 4.383, 4.374,
      4.367, 4.361, 4.361, 4.362, 4.363, 4.364, 4.365, 4.367, 4.368, 4.369, 4.37,  4.368,
      4.365, 4.362, 4.36,  4.357, 4.354, 4.352, 4.349, 4.347, 4.344, 4.341, 4.336, 4.328}},
    {"Cu",
     {1.28,   1.249,  1.206,  1.178,  1.175,  1.179,  1.178,  1.174,  1.171,  1.166,
      1.16,   1.154,  1.148,  1.14,   1.134,  1.127,  1.111,  1.081,  1.033,  0.9582,
      0.8614, 0.7376, 0.6027, 0.4732, 0.3902, 0.324,  0.2718, 0.2459, 0.2266, 0.2166,
      0.212,  0.2093, 0.2112, 0.2132, 0.2148, 0.2167, 0.22,   0.2234, 0.2295, 0.2356,
      0.2414, 0.2472, 0.2509, 0.2525, 0.2542, 0.2564, 0.2586, 0.2624},
     {1.934, 1.972, 2.094, 2.196, 2.13,  2.186, 2.248, 2.301, 2.349, 2.394, 2.436, 2.477,
      2.515, 2.547, 2.574, 2.595, 2.602, 2.593, 2.582, 2.577, 2.593, 2.638, 2.71,  2.805,
      2.943, 3.09,  3.241, 3.378, 3.511, 3.638, 3.752, 3.861, 3.962, 4.062, 4.158, 4.253,
      4.345, 4.436, 4.522, 4.607, 4.692, 4.776, 4.861, 4.948, 5.035, 5.12,  5.204, 5.287}},
    {"W",
     {3.328, 3.429, 3.45,  3.422, 3.39,  3.36,  3.331, 3.317, 3.304, 3.309, 3.311, 3.325,
      3.343, 3.362, 3.396, 3.431, 3.459, 3.484, 3.5,   3.5,   3.493, 3.5,   3.517, 3.539,
      3.56,  3.58,  3.6,   3.632, 3.663, 3.692, 3.725, 3.759, 3.792, 3.822, 3.837, 3.849,
      3.844, 3.838, 3.811, 3.784, 3.74,  3.693, 3.647, 3.603, 3.56,  3.53,  3.5,   3.468},
     {2.695, 2.601, 2.505, 2.442, 2.41,  2.42,  2.43,  2.457, 2.483, 2.526, 2.554, 2.597,
      2.627, 2.656, 2.692, 2.714, 2.72,  2.72,  2.721, 2.729, 2.744, 2.78,  2.817, 2.839,
      2.853, 2.87,  2.89,  2.909, 2.925, 2.937, 2.944, 2.95,  2.929, 2.907, 2.881, 2.854,
      2.816, 2.778, 2.751, 2.724, 2.705, 2.688, 2.69,  2.71,  2.73,  2.753, 2.775, 2.797}},
}};

SampledSpectrum spectrum_of(const std::array<double, kSize>& values) {
  SampledSpectrum result;
  for (std::size_t i = 0; i < kSize; ++i) {
    result.wavelengths_nm.push_back(360 + 10 * static_cast<double>(i));
    result.values.push_back(values[i]);
  }
  return result;
}

/// The spectrum that a name such as "metal-Cu-eta" or "metal-Cu-k" means: a metal's index, from 360
/// to 830 nm.  Nothing for other names.  Silver, aluminium, gold, chromium, copper and tungsten
/// (Ag Al Au Cr Cu W), measured.  [Palik85]
std::optional<SampledSpectrum> metal_spectrum(std::string_view name) {
  for (const Metal& metal : kMetals) {
    if (name == fmt::format("metal-{}-eta", metal.name)) return spectrum_of(metal.eta);
    if (name == fmt::format("metal-{}-k", metal.name)) return spectrum_of(metal.k);
  }
  return std::nullopt;
}

/// Linear between samples; the first and the last one continue.
double value_at(const SampledSpectrum& s, double nm) {
  const auto& at = s.wavelengths_nm;
  const auto above = std::ranges::upper_bound(at, nm);
  if (above == at.begin()) return s.values.front();
  if (above == at.end()) return s.values.back();
  const auto i = static_cast<std::size_t>(above - at.begin());
  const double share = (nm - at[i - 1]) / (at[i] - at[i - 1]);
  return s.values[i - 1] * (1 - share) + s.values[i] * share;
}

/// The RGB of a function of wavelength, as the colour of a surface under D65.
template <typename F>
Rgb under_d65(F&& f) {
  const cie::Illuminant& d65 = *cie::find_illuminant("D65");
  Vec3 xyz{};
  double white = 0;
  for (std::size_t i = 0; i < cie::kObserverSize; ++i) {
    const double nm = cie::kObserverFirstNm + cie::kObserverStepNm * static_cast<double>(i);
    const Vec3 weight = cie::observer()[i] * cie::value_at(d65, nm);
    xyz += weight * f(nm);
    white += weight.y;
  }
  return rgb_from_xyz(xyz / white);
}

/// The index of the spectral line of sodium for the glasses that pbrt-v4 names.  [Schott]
struct Glass {
  std::string_view name;
  double eta;
};
constexpr std::array<Glass, 7> kGlasses{{{"glass-BK7", 1.5168},
                                         {"glass-BAF10", 1.6700},
                                         {"glass-FK51A", 1.4866},
                                         {"glass-LASF9", 1.8503},
                                         {"glass-F5", 1.6727},
                                         {"glass-F10", 1.7283},
                                         {"glass-F11", 1.7847}}};

}  // namespace

Rgb under_d65(const SampledSpectrum& spectrum) {
  return under_d65([&](double nm) { return value_at(spectrum, nm); });
}

std::optional<MetalIndex> metal_index(LoadState& context, const Parameter* eta,
                                      const Parameter* k) {
  const auto spectrum = [&](const Parameter* p,
                            std::string_view otherwise) -> std::optional<SampledSpectrum> {
    if (p == nullptr) return metal_spectrum(otherwise);
    if (p->type != "spectrum") return std::nullopt;
    if (!p->strings().empty())
      if (auto known = metal_spectrum(p->strings().front())) return known;
    return spectrum_samples(context, *p);
  };
  const auto n = spectrum(eta, "metal-Cu-eta"), absorption = spectrum(k, "metal-Cu-k");
  if (!n || !absorption) return std::nullopt;
  MetalIndex index;
  index.eta = under_d65([&](double nm) { return value_at(*n, nm); });
  const auto of_index = [](double e, double a) {
    return ((e - 1) * (e - 1) + a * a) / ((e + 1) * (e + 1) + a * a);
  };
  const Rgb reflected =
      under_d65([&](double nm) { return of_index(value_at(*n, nm), value_at(*absorption, nm)); });
  const auto channel = [](double& e, double r) {
    // Colours out of the gamut.
    e = std::fmax(e, 0);
    r = std::clamp(r, 0.0, 0.9999);
    const double k2 = (r * (e + 1) * (e + 1) - (e - 1) * (e - 1)) / (1 - r);
    return std::sqrt(std::fmax(k2, 0));
  };
  index.k = {channel(index.eta.r, reflected.r), channel(index.eta.g, reflected.g),
             channel(index.eta.b, reflected.b)};
  return index;
}

double index_at_sodium(LoadState& context, const Parameter& parameter) {
  constexpr double kSodiumNm = 589.3;
  if (!parameter.strings().empty())
    for (const Glass& glass : kGlasses)
      if (parameter.strings().front() == glass.name) {
        context.remark(parameter.place,
                       fmt::format("the dispersion of \"{}\" is not modelled", glass.name),
                       fmt::format("index {}, that of yellow light", glass.eta));
        return glass.eta;
      }
  const SampledSpectrum samples = spectrum_samples(context, parameter);
  const double eta = value_at(samples, kSodiumNm);
  if (!is_constant(samples))
    context.remark(parameter.place, "the dispersion of a spectrum \"eta\" is not modelled",
                   fmt::format("index {:.4g}, that of yellow light", eta));
  return eta;
}

}  // namespace lucerna::pbrt
