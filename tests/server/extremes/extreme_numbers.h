// Random numbers that no client sends on purpose: of all magnitudes, and special values.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna::testing {

class ExtremeNumbers {
 public:
  explicit ExtremeNumbers(std::uint64_t seed) : bits_(seed) {}

  /// In [0, 1).
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  double uniform(double from, double to) { return from + (to - from) * uniform(); }
  bool chance(double probability) { return uniform() < probability; }
  std::uint64_t below(std::uint64_t n) { return bits_() % n; }
  template <typename T>
  const T& one_of(const std::vector<T>& all) {
    return all[below(all.size())];
  }

  /// Log-uniformly distributed.
  double magnitude(double least = 1e-30, double most = 1e30) {
    return std::exp(uniform(std::log(least), std::log(most)));
  }
  double with_sign(double magnitude) { return chance(0.5) ? magnitude : -magnitude; }

  /// Any value that a message can hold in a float.  One in six is special, and a few of those are
  /// not finite.
  float component() {
    using Limits = std::numeric_limits<float>;
    if (!chance(1.0 / 6)) return static_cast<float>(with_sign(magnitude()));
    switch (below(64)) {
      case 0:
        return Limits::quiet_NaN();
      case 1:
        return static_cast<float>(with_sign(1)) * Limits::infinity();
      default:
        break;
    }
    switch (below(8)) {
      case 0:
        return static_cast<float>(with_sign(Limits::max()));
      case 1:
        return static_cast<float>(with_sign(Limits::min()));
      case 2:
        return static_cast<float>(with_sign(1)) * Limits::denorm_min() *
               static_cast<float>(below(1 << 23));
      case 3:
        return static_cast<float>(with_sign(1));
      default:
        return chance(0.5) ? 0.0F : -0.0F;
    }
  }

  /// Half of the time the components are independent, otherwise they have one scale.
  Vec3f vector() {
    if (chance(0.5)) return {component(), component(), component()};
    const double scale = magnitude();
    return Vec3f(direction() * scale);
  }

  /// A unit vector.  One in four lies in a coordinate plane or along an axis.
  Vec3 direction() {
    const double z = uniform(-1, 1), phi = uniform(0, 2 * std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    Vec3 w{r * std::cos(phi), r * std::sin(phi), z};
    switch (below(8)) {
      case 0:
        return {0, 0, with_sign(1)};
      case 1:
        w.y = 0;
        break;
      default:
        break;
    }
    return normalized(w);
  }

  /// In [0, 1].  A third are at the ends or next to them; one in 300 is not finite.
  float sample_value() {
    if (!chance(1.0 / 3)) return static_cast<float>(below(1 << 24)) * 0x1p-24F;
    switch (below(9)) {
      case 0:
        return chance(0.1) ? std::numeric_limits<float>::quiet_NaN() : 0.25F;
      case 1:
        return 1;
      case 2:
        return 1 - 0x1p-24F;
      case 3:
        return 0x1p-24F;
      case 4:
        return std::numeric_limits<float>::denorm_min();
      case 5:
        return 0.5F;
      case 6:
        return static_cast<float>(magnitude(1e-30, 1));
      default:
        return 0;
    }
  }
  /// In [0, 1).
  double choosing_value() {
    if (chance(0.8)) return uniform();
    return chance(0.5) ? 0 : 1 - 0x1p-53;
  }

  /// Any finite double.
  double scalar() {
    switch (below(8)) {
      case 0:
        return 0;
      case 1:
        return with_sign(magnitude(1e-300, 1e300));
      case 2:
      case 3:
        return with_sign(magnitude());
      default:
        return uniform(-1, 2);
    }
  }

  std::uint64_t seed() { return bits_(); }

 private:
  std::mt19937_64 bits_;
};

}  // namespace lucerna::testing
