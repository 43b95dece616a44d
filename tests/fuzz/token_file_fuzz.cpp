// Reads the input as the file of tokens.
#include <cstdlib>

#include "server/rpc/token_file.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lucerna;
  const fuzz::UnnamedFile file(fuzz::text_of(data, size));
  const fuzz::AllocationBound bound("token file", size);
  const auto tokens = access::read_token_file(file.path());
  bound.require_at_most(bound.peak_bytes(), fuzz::kTomlFactor * size + fuzz::kTomlFixedBytes);
  if (!tokens.ok()) return 0;
  for (const access::Token& token : *tokens)
    if (token.name.empty() || token.sha256.size() != 32 || token.roles.empty()) std::abort();
  return 0;
}
