// Cuts the space of directions and receivers into cells of equal probability, by samples.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace lucerna::verify {

/// Where a sample goes (three coordinates: a direction, or a place beside a local light), and the
/// receiver (three).
using Feature = std::array<double, 6>;

/// A k-d tree.  Each cut halves the reference samples of a cell across its widest coordinate, so
/// each leaf has nearly the same probability under the density of the reference.
class Partition {
 public:
  /// At most `cells` leaves; fewer if samples coincide.  The coordinates of receivers count
  /// relative to their spread.  `reference` must not be empty.
  Partition(const std::vector<Feature>& reference, std::size_t cells);

  std::size_t cells() const { return cells_; }
  /// The leaf of a feature, below cells().
  std::size_t cell(const Feature& f) const;
  /// The share of the reference samples in each leaf.
  const std::vector<double>& probabilities() const { return probabilities_; }

 private:
  struct Node {
    int coordinate = -1;  // -1: a leaf
    double below = 0;     // smaller coordinates go to `left`
    std::size_t left = 0, right = 0;
    std::size_t leaf = 0;
  };
  std::size_t build(std::vector<Feature>& all, std::size_t begin, std::size_t end,
                    std::size_t want);

  std::vector<Node> nodes_;
  std::vector<double> probabilities_;
  std::array<double, 6> scale_{};
  std::size_t cells_ = 0;
  std::size_t total_ = 0;
};

}  // namespace lucerna::verify
