// Reads the input as a photometric file, and looks its intensities up.
#include <cmath>
#include <cstdlib>

#include "server/formats/eulumdat.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const lucerna::fuzz::AllocationBound bound("EULUMDAT", size);
  const auto file = lucerna::parse_eulumdat(lucerna::fuzz::text_of(data, size), "file.ldt");
  // A web holds the planes that follow from its symmetry too.
  bound.require(bound.peak_beyond_result_bytes());
  if (!file.ok()) return 0;
  for (const double z : {-1.0, -0.3, 0.0, 0.3, 1.0})
    if (!std::isfinite(file->web->at({0.6, -0.8, z}))) std::abort();
  return 0;
}
