#include "server/runtime/isa.h"

namespace lucerna {

const std::array<InstructionSet, 5>& instruction_sets() {
  static constexpr std::array<InstructionSet, 5> kIsas{{
      {"sse2", "sse2", [] { return true; }},
      {"sse4.2", "sse42", [] { return __builtin_cpu_supports("sse4.2") != 0; }},
      {"avx", "avx", [] { return __builtin_cpu_supports("avx") != 0; }},
      {"avx2", "avx2",
       [] {
         return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
       }},
      {"avx512", "avx512",
       [] {
         return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
                __builtin_cpu_supports("avx512vl");
       }},
  }};
  return kIsas;
}

}  // namespace lucerna
