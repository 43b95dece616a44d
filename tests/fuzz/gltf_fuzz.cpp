// Reads the input as a glTF file.  Its buffer may be a further file, or the file itself.
#include "server/gltf/load_gltf.h"
#include "tests/fuzz/input_files.h"
#include "tests/fuzz/requirements.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lucerna;
  constexpr std::uint64_t kMostPrimitives = 20000, kMostTexels = 1 << 12;
  const std::string_view input = fuzz::text_of(data, size);
  const std::string name = input.starts_with("glTF") ? "scene.glb" : "scene.gltf";
  AssetReader assets(std::make_unique<fuzz::InputFiles>(input, name));
  fuzz::require_sound(
      load_gltf(assets, name, {}, {.max_texels = kMostTexels, .max_primitives = kMostPrimitives}));
  return 0;
}
