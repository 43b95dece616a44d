#include "server/pbrt/older_pbrt.h"

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
    {"directive", "WorldEnd"},
    {"parameter", "rgb scale"},
    {"parameter", "spectrum scale"},
    {"parameter type", "color"},
    {"parameter type", "xyz"},
});

/// Directives of pbrt-v2, which pbrt-v3 does not know either.
constexpr std::array<std::string_view, 4> kVersion2{"Renderer", "SurfaceIntegrator", "Volume",
                                                    "VolumeIntegrator"};

struct Renamed {
  std::string_view old, now;
};
constexpr auto kRenamed = std::to_array<Renamed>({
    {"Kd", "reflectance"},
    {"bumpmap", "displacement"},
    {"gamma", "encoding"},
    {"index", "eta"},
    {"lightsamplestrategy", "lightsampler"},
    {"mapname", "filename"},
    {"maxsampleluminance", "maxcomponentvalue"},
    {"nlevels", "levels"},
    {"nsamples", "samples"},
    {"tex1", "tex"},  // of a "scale"
    {"tex2", "scale"},
    {"trilinear", "filter"},
    {"xwidth", "xradius"},
    {"ywidth", "yradius"},
});

}  // namespace

std::string_view hint_of_older_pbrt(std::string_view kind, std::string_view word) {
  if (kind == "directive" && std::ranges::find(kVersion2, word) != kVersion2.end())
    return "; this is a pbrt-v2 file, allowed: files of pbrt-v4";
  const bool is_of_3 = std::ranges::any_of(
      kVersion3, [&](const Word& w) { return w.kind == kind && w.word == word; });
  return is_of_3 ? kIsOfPbrt3 : "";
}

std::string_view name_in_pbrt_v4(std::string_view parameter) {
  const auto renamed = std::ranges::find(kRenamed, parameter, &Renamed::old);
  return renamed == kRenamed.end() ? "" : renamed->now;
}

}  // namespace lucerna::pbrt
