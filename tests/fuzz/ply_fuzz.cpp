// Reads the input as a mesh.
#include "server/formats/ply.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const lucerna::fuzz::AllocationBound bound("PLY", size);
  static_cast<void>(lucerna::parse_ply(lucerna::fuzz::text_of(data, size)));
  bound.require(bound.peak_bytes());
  return 0;
}
