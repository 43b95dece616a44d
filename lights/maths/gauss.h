// Gauss's rule for integrals of smooth functions.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace lucerna {

/// Nodes and weights for the integral from 0 to 1 of polynomials up to degree 2 kNodes - 1.
template <std::size_t kNodes>
struct Gauss {
  std::array<double, kNodes> node, weight;

  Gauss() {
    // The roots of the Legendre polynomial by Newton's method.  [DLMF, 3.5(v), 18.16(ii)]
    constexpr double kDegree = kNodes;
    for (std::size_t k = 0; k < kNodes; ++k) {
      double x = std::cos(std::numbers::pi * (static_cast<double>(k) + 0.75) / (kDegree + 0.5));
      double slope = 0;
      for (int step = 0; step < 20; ++step) {
        double before = 1, p = x;
        for (double n = 2; n <= kDegree; ++n)
          before = std::exchange(p, ((2 * n - 1) * x * p - (n - 1) * before) / n);
        slope = kDegree * (x * p - before) / (x * x - 1);
        x -= p / slope;
      }
      node[k] = (1 + x) / 2;
      weight[k] = 1 / ((1 - x * x) * slope * slope);
    }
  }
};

template <std::size_t kNodes>
const Gauss<kNodes>& gauss() {
  static const Gauss<kNodes> rule;
  return rule;
}

}  // namespace lucerna
