// Gauss-Legendre quadrature.
#pragma once

#include <array>
#include <cstddef>

#include "tests/oracle/cells.h"

namespace lucerna::oracle {

/// Points and weights in [0, 1].
struct Rule {
  int points;
  std::array<Real, 4> at, weight;
};
inline constexpr Rule kTwo{
    2, {0.211324865405187117745425609749L, 0.788675134594812882254574390251L}, {0.5L, 0.5L}};
inline constexpr Rule kThree{
    3,
    {0.112701665379258311482073460022L, 0.5L, 0.887298334620741688517926539978L},
    {0.277777777777777777777777777778L, 0.444444444444444444444444444444L,
     0.277777777777777777777777777778L}};
inline constexpr Rule kFour{4,
                            {0.0694318442029737123880267555536L, 0.330009478207571867598667120448L,
                             0.669990521792428132401332879552L, 0.930568155797026287611973244446L},
                            {0.173927422568726928686531974611L, 0.326072577431273071313468025389L,
                             0.326072577431273071313468025389L, 0.173927422568726928686531974611L}};

/// The elements of a cell at the points of Gauss's rule in each direction, with their weights.  One
/// evaluation of the emitter serves several eyes.
struct Nodes {
  std::size_t count = 0;
  std::array<Cell::Element, 16> elements{};
  std::array<Real, 16> weights{};
};

inline Nodes nodes_of(const Cell& c, const Rule& rule) {
  Nodes nodes;
  const Real area = (c.s1 - c.s0) * (c.t1 - c.t0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(rule.points); ++i) {
    for (std::size_t j = 0; j < static_cast<std::size_t>(rule.points); ++j) {
      nodes.elements[nodes.count] =
          c.element(c.s0 + (c.s1 - c.s0) * rule.at[i], c.t0 + (c.t1 - c.t0) * rule.at[j]);
      nodes.weights[nodes.count++] = rule.weight[i] * rule.weight[j] * area;
    }
  }
  return nodes;
}

/// The integral over the cell's parameters.
template <typename F>
Real integral_over(const Nodes& nodes, const F& f) {
  Real total = 0;
  for (std::size_t i = 0; i < nodes.count; ++i) total += nodes.weights[i] * f(nodes.elements[i]);
  return total;
}

}  // namespace lucerna::oracle
