// libFuzzer target: the bytes as a scene file that may include itself, and as a mesh.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "server/pbrt/load.h"
#include "server/ply.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string root = [] {
    std::string name = (std::filesystem::temp_directory_path() / "lucerna-fuzz-XXXXXX").string();
    return std::string(mkdtemp(name.data()));
  }();
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  std::ofstream(root + "/scene.pbrt", std::ios::binary) << bytes;
  auto assets = lucerna::AssetReader::open(root);
  if (assets.ok()) static_cast<void>(lucerna::load_pbrt(*assets, "scene.pbrt"));
  static_cast<void>(lucerna::parse_ply(bytes));
  return 0;
}
