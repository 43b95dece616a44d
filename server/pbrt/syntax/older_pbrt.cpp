#include "server/pbrt/syntax/older_pbrt.h"

#include <algorithm>
#include <array>

namespace lucerna::pbrt {
namespace {

struct Word {
  std::string_view kind, word;
};

/// Words of pbrt-v3 that pbrt-v4 does not know.
constexpr auto kVersion3 = std::to_array<Word>({
    {"Material", "disney"},
    {"Material", "fourier"},
    {"Material", "glass"},
    {"Material", "kdsubsurface"},
    {"Material", "matte"},
    {"Material", "metal"},
    {"Material", "mirror"},
    {"Material", "plastic"},
    {"Material", "shinymetal"},
    {"Material", "substrate"},
    {"Material", "translucent"},
    {"Material", "uber"},
    {"Film", "image"},
    {"Integrator", "directlighting"},
    {"Integrator", "whitted"},
    {"Sampler", "02sequence"},
    {"Sampler", "bestcandidate"},
    {"Sampler", "lowdiscrepancy"},
    {"Sampler", "maxmindist"},
    {"Sampler", "random"},
    {"Camera", "environment"},
    {"Shape", "cone"},
    {"Shape", "heightfield"},
    {"Shape", "hyperboloid"},
    {"Shape", "nurbs"},
    {"Shape", "paraboloid"},
    {"texture type", "color"},
    {"parameter type", "color"},
    {"parameter type", "xyz"},
});

/// Directives of pbrt-v2, which pbrt-v3 does not know either.
constexpr std::array<std::string_view, 4> kVersion2{"Renderer", "SurfaceIntegrator", "Volume",
                                                    "VolumeIntegrator"};

}  // namespace

std::string_view hint_of_older_pbrt(std::string_view kind, std::string_view word) {
  if (kind == "directive" && std::ranges::find(kVersion2, word) != kVersion2.end())
    return "; this is a pbrt-v2 file, allowed: files of pbrt-v4";
  const bool is_of_3 = std::ranges::any_of(
      kVersion3, [&](const Word& w) { return w.kind == kind && w.word == word; });
  return is_of_3 ? "; this is a pbrt-v3 file; pbrt-v4's --upgrade converts it" : "";
}

std::string_view name_in_pbrt_v4(std::string_view parameter) {
  if (parameter == "mapname") return "filename";
  if (parameter == "nsamples") return "samples";
  if (parameter == "bumpmap") return "displacement";
  if (parameter == "Kd") return "reflectance";
  if (parameter == "index") return "eta";
  return "";
}

}  // namespace lucerna::pbrt
