// One denormals policy on every thread that computes: denormal inputs and results are zero.
//
// Embree recommends it, because a denormal costs over a hundred cycles in its kernels.  An answer
// must not depend on the thread that computes it.  But each thread has its own control register,
// and in oneTBB's workers its initial value depends on the thread that made the arena.
#pragma once

#include <immintrin.h>

namespace lucerna {

/// While it lives, this thread flushes denormal results to zero, reads denormals as zero, rounds to
/// nearest and raises no floating-point traps.  Put one at the start of every chunk of work.
class DenormalsAreZero {
 public:
  DenormalsAreZero() : saved_(_mm_getcsr()) { _mm_setcsr(kPolicy); }
  ~DenormalsAreZero() { _mm_setcsr(saved_); }
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;

 private:
  // FTZ (bit 15), DAZ (bit 6), all exceptions masked (bits 7 to 12), round to nearest.
  static constexpr unsigned kPolicy = 0x8000 | 0x0040 | 0x1f80;
  unsigned saved_;
};

}  // namespace lucerna
