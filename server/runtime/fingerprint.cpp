#include "server/runtime/fingerprint.h"

#include <fmt/core.h>
#include <gnu/libc-version.h>

#include "proto/common/sha256.h"

namespace lucerna {

Fingerprint numeric_fingerprint(const std::string& embree) {
  Fingerprint f;
  f.build = LUCERNA_BUILD;
  f.embree = embree;
  // glibc chooses variants of its functions by the processor.  Variants with fused multiply-add may
  // round differently.
  f.libm = fmt::format("glibc {}{}{}", gnu_get_libc_version(),
                       __builtin_cpu_supports("fma") ? " fma" : "",
                       __builtin_cpu_supports("avx2") ? " avx2" : "");
  const std::string all = f.build + '\0' + f.embree + '\0' + f.libm;
  f.digest = hexadecimal(sha256(all).substr(0, 16));
  return f;
}

}  // namespace lucerna
