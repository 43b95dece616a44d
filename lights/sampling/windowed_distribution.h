// Points of any rectangle within the unit square, with a density that follows a grid of weights.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

/// A grid of n x n cells, each with a weight.  Points are drawn from a window of the square with a
/// density proportional to the weights.  A share of the points is uniform over the window, so a
/// weight that is too small does not make a sample much too bright.  Immutable.  [Bitterli15]
///
/// Weights are stored as sums of integers over all rectangles that begin at the corner.  Their
/// differences are exact, so a window with 1e-12 of all weight is sampled as well as the whole
/// square.
class WindowedDistribution {
 public:
  /// The part of the samples that is uniform over the window.
  static constexpr double kUniformShare = 1.0 / 16;

  /// [x, x + width] x [y, y + height], inside the unit square to within rounding.  It stores
  /// extents, because differences of ends would cancel for small windows.
  struct Window {
    double x = 0, y = 0, width = 1, height = 1;
  };
  struct Sample {
    Vec2 position;
    double pdf;  ///< with respect to the square's area
  };

  /// `weights`: n x n numbers, rows of x one after another, finite, not negative.  Weights below
  /// 2^-40 of the largest are raised to that.
  WindowedDistribution(int n, const std::vector<double>& weights);

  /// For any u of the closed unit square and a window of positive extents.
  Sample sample(const Window& window, Vec2 u) const;
  /// The density with which `sample` gives points of the window. Not finite if the window is too
  /// small for doubles.
  double pdf(const Window& window, Vec2 position) const;

  int size() const { return n_; }
  std::size_t bytes() const { return sizeof(*this) + sums_.capacity() * sizeof(std::uint64_t); }

 private:
  /// The cells that one side of a window covers: the part `head` of the first cell, the part `tail`
  /// of the last cell if it is another one, and all cells between.
  struct Span {
    int first, last;
    double head, tail;
    double share_of(int cell) const { return cell == first ? head : cell == last ? tail : 1; }
  };
  Span span(double begin, double extent) const;
  /// The weight of the cells [x0, x1) x [y0, y1).
  std::uint64_t block(int x0, int x1, int y0, int y1) const;
  /// The weight within the window's columns up to and including `to`, and the rows [y0, y1).
  double across(const Span& x, int to, int y0, int y1) const;
  /// The weight within the window's columns, and its rows up to and including `to`.
  double down(const Span& x, const Span& y, int to) const;
  double density(const Window& window, double total, Vec2 position) const;

  int n_;
  std::vector<std::uint64_t> sums_;  ///< (n + 1) x (n + 1)
};

}  // namespace lucerna
