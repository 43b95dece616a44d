// A box along the axes.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "lights/maths/vec.h"

namespace lucerna {

/// The smallest box around points; empty without any.
struct Bounds {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 lower{kInfinity, kInfinity, kInfinity}, upper{-kInfinity, -kInfinity, -kInfinity};
  bool empty() const { return lower.x > upper.x; }
  void add(const Vec3& p) {
    // Compiles to x86's own minimum and maximum; std::fmin is a call.
    const auto lesser = [](double a, double least) { return a < least ? a : least; };
    const auto larger = [](double a, double most) { return a > most ? a : most; };
    lower = {lesser(p.x, lower.x), lesser(p.y, lower.y), lesser(p.z, lower.z)};
    upper = {larger(p.x, upper.x), larger(p.y, upper.y), larger(p.z, upper.z)};
  }
  std::array<Vec3, 8> corners() const {
    std::array<Vec3, 8> all;
    for (std::size_t i = 0; i < 8; ++i)
      all[i] = {i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z};
    return all;
  }
};

}  // namespace lucerna
