// libFuzzer target: reads the bytes as a scene file, which may include itself, and as a mesh.
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>

#include "server/formats/ply.h"
#include "server/pbrt/load.h"
#include "tests/temp_directory.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const lucerna::TempDirectory directory;
  static const std::string root = directory.path().string();
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  std::ofstream(root + "/scene.pbrt", std::ios::binary) << bytes;
  auto assets = lucerna::AssetReader::open(root);
  if (assets.ok()) static_cast<void>(lucerna::load_pbrt(*assets, "scene.pbrt"));
  static_cast<void>(lucerna::parse_ply(bytes));
  return 0;
}
