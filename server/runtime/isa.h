// Instruction sets of Embree's kernels.
#pragma once

#include <array>

namespace lucerna {

struct InstructionSet {
  const char* name;     ///< as in requests and answers
  const char* embree;   ///< as in Embree's configuration
  bool (*supported)();  ///< by this machine
};

/// In ascending order.
const std::array<InstructionSet, 5>& instruction_sets();

}  // namespace lucerna
