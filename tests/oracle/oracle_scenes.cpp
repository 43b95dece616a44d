// Writes the oracle's first scenes and rooms as .pbrt files: oracle_scenes FOLDER SCENES ROOMS
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/oracle/interior.h"

namespace {

void write(const std::filesystem::path& file, const std::string& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace

int main(int argc, char** argv) {
  namespace oracle = lucerna::oracle;
  if (argc != 4) {
    fmt::print(stderr, "usage: oracle_scenes FOLDER SCENES ROOMS\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  for (std::uint64_t i = 0; i < std::stoull(argv[2]); ++i) {
    const oracle::World world = oracle::random_world(i);
    // Pictures of different scenes have the same names.
    const std::filesystem::path own = folder / fmt::format("scene{:06}", i);
    write(own / "scene.pbrt", pbrt_text(world));
    for (const auto& [name, bytes] : pbrt_files(world)) write(own / name, bytes);
  }
  for (std::uint64_t i = 0; i < std::stoull(argv[3]); ++i)
    write(folder / fmt::format("room{:06}.pbrt", i), pbrt_text(oracle::random_interior(i)));
}
