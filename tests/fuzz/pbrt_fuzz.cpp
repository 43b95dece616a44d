// Reads the input as a scene file, and the further files that it names.
#include <algorithm>
#include <string_view>

#include "server/pbrt/load_pbrt.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"
#include "tests/fuzz/requirements.h"
#include "tests/server/files/limited_pool.h"

namespace {

bool is_picture(std::string_view name) {
  return !name.ends_with(".pbrt") && !name.ends_with(".ply") && !name.ends_with(".ies") &&
         !name.ends_with(".ldt") && !name.ends_with(".spd");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lucerna;
  // A few bytes can ask for any number of primitives or texels, so limits bound each run.
  constexpr std::uint64_t kMostPrimitives = 20000, kMostTexels = 1 << 16;
  constexpr std::uint64_t kMostTokens = 1 << 18, kMostFileBytes = 1 << 24;
  testing::LimitedPool pool;
  LoadBudget budget(&pool);
  AssetReader assets(
      std::make_unique<fuzz::InputFiles>(fuzz::text_of(data, size), "scene.pbrt"),
      {.max_total_bytes = kMostFileBytes, .max_unpacked_bytes = kMostFileBytes, .budget = &budget});
  const fuzz::AllocationBound bound(".pbrt", size);
  const auto scene = load_pbrt(assets, "scene.pbrt", {},
                               {.max_texels = kMostTexels,
                                .max_primitives = kMostPrimitives,
                                .max_tokens = kMostTokens,
                                .budget = &budget});
  const std::uint64_t peak = bound.peak_bytes();
  fuzz::require_sound(scene);
  // OpenImageIO asks for 64 MiB at once, of which it uses what it needs.
  if (std::ranges::any_of(assets.assets(), [](const Asset& a) { return is_picture(a.name); }))
    return 0;
  // Short directives become objects that the memory budget counts.
  bound.require_at_most(
      peak, fuzz::AllocationBound::kFactor * size + fuzz::kPbrtFixedBytes + pool.most());
  return 0;
}
