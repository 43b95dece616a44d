// Reads the input as the configuration file of lucernad.
#include "server/lucernad/configuration.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lucerna;
  const fuzz::UnnamedFile file(fuzz::text_of(data, size));
  const fuzz::AllocationBound bound("configuration", size);
  const config::Configuration configuration = config::configure({.file = file.path()});
  bound.require_at_most(bound.peak_bytes(), fuzz::kTomlFactor * size + fuzz::kTomlFixedBytes);
  // A configuration without errors can be printed and read again.
  if (configuration.errors.empty()) static_cast<void>(config::describe(configuration));
  return 0;
}
