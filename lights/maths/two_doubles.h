// Two doubles that the processor computes at once.
//
// Each of both has the bits that the same operations give for one double.
#pragma once

#if defined(__SSE2__)
#include <emmintrin.h>
#else
#include <cmath>
#endif

#include <cstdint>

namespace lucerna {

using TwoDoubles = double __attribute__((vector_size(16)));
/// Comparisons give -1 (all bits) where they hold, else 0.  `mask ? a : b` selects.
using TwoMasks = std::int64_t __attribute__((vector_size(16)));

inline TwoDoubles both(double v) { return TwoDoubles{v, v}; }
inline TwoDoubles both(const float (&v)[2]) { return TwoDoubles{double{v[0]}, double{v[1]}}; }
inline TwoDoubles both(const double (&v)[2]) { return TwoDoubles{v[0], v[1]}; }

inline TwoDoubles sqrt(const TwoDoubles& v) {
#if defined(__SSE2__)
  return _mm_sqrt_pd(v);
#else
  return TwoDoubles{std::sqrt(v[0]), std::sqrt(v[1])};
#endif
}
/// As std::max: the first one unless it is less than the second.
inline TwoDoubles max(const TwoDoubles& a, const TwoDoubles& b) { return a < b ? b : a; }
inline TwoDoubles abs(const TwoDoubles& v) { return v < 0 ? -v : v; }

}  // namespace lucerna
