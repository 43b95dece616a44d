// Reads the input as a photometric file, and looks its intensities up.
#include "server/files/ies.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"
#include "tests/fuzz/requirements.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const lucerna::fuzz::AllocationBound bound("IES", size);
  const auto file = lucerna::parse_ies(lucerna::fuzz::text_of(data, size), "file.ies");
  // A web holds the planes that follow from its symmetry too.
  bound.require(bound.peak_beyond_result_bytes());
  lucerna::fuzz::require_sound(file);
  return 0;
}
