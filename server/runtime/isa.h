// Instruction sets that kernels are compiled for.
#pragma once

#include <array>

namespace lucerna {

struct InstructionSet {
  const char* name;     ///< as requests and answers say it
  const char* embree;   ///< as Embree's configuration says it
  bool (*supported)();  ///< by this machine
};

/// From the least to the best.
const std::array<InstructionSet, 5>& instruction_sets();

}  // namespace lucerna
