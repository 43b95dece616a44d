// libFuzzer target: reads the bytes as a glTF file, whose buffer may be the file itself.
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>

#include "server/gltf/load.h"
#include "tests/temp_directory.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const lucerna::TempDirectory directory;
  static const std::string root = directory.path().string();
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  std::ofstream(root + "/scene.gltf", std::ios::binary) << bytes;
  auto assets = lucerna::AssetReader::open(root);
  if (assets.ok()) static_cast<void>(lucerna::load_gltf(*assets, "scene.gltf"));
  return 0;
}
