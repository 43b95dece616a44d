// Reads the input as a mesh.
#include <cstdint>
#include <cstdlib>

#include "server/files/ply.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const lucerna::fuzz::AllocationBound bound("PLY", size);
  const auto mesh = lucerna::parse_ply(lucerna::fuzz::text_of(data, size));
  bound.require(bound.peak_bytes());
  if (!mesh.ok()) return 0;
  for (const std::uint32_t index : mesh->indices)
    if (index >= mesh->positions.size()) std::abort();
  return 0;
}
