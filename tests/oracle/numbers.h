// Random numbers.
#pragma once

#include <cmath>
#include <cstdint>

#include "tests/oracle/oracle_vec.h"

namespace lucerna::oracle {

/// SplitMix64 [Steele14].
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed) { state_ = next() ^ seed << 32; }
  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double between(double a, double b) { return a + (b - a) * uniform(); }
  /// 10^x, with x uniform.
  double power(double a, double b) { return std::pow(10.0, between(a, b)); }
  bool chance(double p) { return uniform() < p; }
  int below(int n) { return static_cast<int>(uniform() * n); }
  /// Uniform over the unit sphere.
  Vec direction() {
    const double z = between(-1, 1), angle = 2 * std::numbers::pi * uniform();
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

inline Vec doubles(const Vec& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
inline Vec floats(const Vec& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace lucerna::oracle
