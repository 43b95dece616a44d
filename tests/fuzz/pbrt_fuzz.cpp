// Reads the input as a scene file, and the further files that it names.
#include "server/pbrt/load.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lucerna;
  // A few bytes can ask for any number of primitives or texels, so limits bound each run.
  constexpr std::uint64_t kMostPrimitives = 20000, kMostTexels = 1 << 16;
  constexpr std::uint64_t kMostTokens = 1 << 18, kMostFileBytes = 1 << 24;
  AssetReader assets(std::make_unique<fuzz::InputFiles>(fuzz::text_of(data, size), "scene.pbrt"),
                     {.max_total_bytes = kMostFileBytes, .max_unpacked_bytes = kMostFileBytes});
  const fuzz::AllocationBound bound(".pbrt", size);
  const auto scene = load_pbrt(
      assets, "scene.pbrt", {},
      {.max_texels = kMostTexels, .max_primitives = kMostPrimitives, .max_tokens = kMostTokens});
  bound.require(bound.peak_beyond_result_bytes());
  return 0;
}
