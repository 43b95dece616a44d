// Reads the input as the picture of a surface, and looks it up.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <string>

#include "server/pbrt/load_pbrt.h"
#include "server/scene/emitter_alpha.h"
#include "tests/fuzz/input_files.h"
#include "tests/fuzz/requirements.h"

namespace {

/// Chooses among words by a byte.
template <std::size_t n>
std::string one_of(const char* const (&words)[n], std::uint8_t byte) {
  return words[byte % n];
}

}  // namespace

/// The first five bytes choose the parameters of the texture.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kParameters = 5;
  if (size < kParameters) return 0;
  const char* const wraps[] = {"repeat", "black", "clamp", "octahedralsphere"};
  const char* const filters[] = {"point", "bilinear", "trilinear", "ewa"};
  const char* const mappings[] = {"uv", "spherical", "cylindrical", "planar"};
  const char* const encodings[] = {"sRGB", "linear", "gamma 2.2"};
  const char* const pictures[] = {"picture.png", "picture.exr", "picture.pfm"};
  const std::string picture = one_of(pictures, data[4] / 2);
  const std::string parameters =
      " \"imagemap\" \"string filename\" \"" + picture + "\" \"string wrap\" \"" +
      one_of(wraps, data[0]) + "\" \"string filter\" \"" + one_of(filters, data[1]) +
      "\" \"string mapping\" \"" + one_of(mappings, data[2]) + "\" \"string encoding\" \"" +
      one_of(encodings, data[3]) + "\" \"bool invert\" " + (data[4] % 2 == 0 ? "true" : "false") +
      " ";
  const std::string input =
      "WorldBegin AreaLightSource \"diffuse\" Texture \"c\" \"spectrum\"" + parameters +
      "Texture \"a\" \"float\"" + parameters +
      "Material \"diffuse\" \"texture reflectance\" \"c\" \"texture displacement\" \"a\" "
      "Shape \"sphere\" \"texture alpha\" \"a\"\n#FILE " +
      picture + "\n" + std::string(lucerna::fuzz::text_of(data + kParameters, size - kParameters));
  constexpr std::uint64_t kMostTexels = 1 << 12;
  lucerna::AssetReader assets(std::make_unique<lucerna::fuzz::InputFiles>(input, "scene.pbrt"));
  auto description = lucerna::load_pbrt(assets, "scene.pbrt", {}, {.max_texels = kMostTexels});
  lucerna::fuzz::require_sound(description);
  if (!description.ok()) return 0;
  const lucerna::Textures& textures = description->textures;
  // A scene would also open an Embree device, which takes far longer than the picture.
  static_cast<void>(lucerna::apply_alpha(*description));
  // No area, a round one, a long one, and one that covers the picture many times.
  const lucerna::Footprint round{{0.1, 0, 0}, {0, 0.1, 0}, {0.1, 0}, {0, 0.1}},
      slim{{0.3, 0.2, 0}, {0, 1e-3, 0}, {0.3, 0.2}, {0, 1e-3}},
      endless{{1e300, 0, 0}, {0, 1e300, 0}, {1e300, 0}, {0, 1e300}};
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(textures.size()); ++t)
    for (const double u : {-1e300, -0.3, 0.0, 0.5, 1.0, 7.25, 1e300})
      for (const double v : {-1e300, 0.0, 0.75, 1.0, 1e300}) {
        const lucerna::Vec3 p{u, v, 0.5};
        for (const lucerna::Footprint* f :
             std::initializer_list<const lucerna::Footprint*>{nullptr, &round, &slim, &endless}) {
          const lucerna::TexturePoint at{
              .uv = {u, v}, .position = p, .normal = {0, 0, 1}, .footprint = f};
          if (!is_finite(textures(lucerna::ColourValue{{}, t}, at))) std::abort();
        }
      }
  return 0;
}
