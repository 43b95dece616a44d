// Points of the unit square with a density proportional to a picture's filtered texels: constant
// over each texel, or bilinear between the centres of texels.
#pragma once

#include <cstddef>
#include <vector>

#include "lights/maths/vec.h"
#include "lights/pictures/image.h"

namespace lucerna {

/// The luminance of each texel minus `subtract`, where that is positive.
std::vector<double> luminances(const Image& image, double subtract = 0);

/// Immutable.  Sums and cumulative distributions are in double.  So one texel of 1e9 in a picture
/// of 1 does not reduce the others' probability to 0.
///
/// The square is cut into rows of cells.  For the nearest filter they are the texels.  For the
/// bilinear filter they are the squares between centres, and halves at the border.  Each row has a
/// measure as weight, by default its height.
class ImageDistribution {
 public:
  struct Sample {
    Vec2 position;  ///< in the closed unit square
    double pdf;     ///< with respect to the square's area; 0: all weights are 0
  };

  /// `weights`: width times height, rows from the top, finite, not negative.  `row_measures`: one
  /// for each row of cells, not negative; empty: their heights.  The nearest filter has `height`
  /// rows of cells, the bilinear filter `height` + 1.
  ImageDistribution(int width, int height, std::vector<double> weights, ImageFilter filter,
                    ImageBorder border, std::vector<double> row_measures = {});
  /// By the luminance of an image.
  ImageDistribution(const Image& image, ImageFilter filter, ImageBorder border)
      : ImageDistribution(image.width(), image.height(), luminances(image), filter, border) {}

  /// For any u of the closed unit square.
  Sample sample(Vec2 u) const;
  /// The density with which `sample` gives points of the closed unit square, with respect to area.
  double pdf(Vec2 position) const;
  /// The integral over the square of the filtered weights, times the measure of each row relative
  /// to its height.  With the default measures it is the mean weight.
  double integral() const { return rows_.back(); }

  std::size_t bytes() const;

 private:
  /// A cell along one axis: [begin, end] of the square, and [share_begin, share_end] of the way
  /// between two centres.
  struct Span {
    double begin, end, share_begin, share_end;
  };
  /// The weights at the corners of a cell: w[j][i] in row j, column i.
  struct Corners {
    double w[2][2];
    double mean() const { return (w[0][0] + w[0][1] + w[1][0] + w[1][1]) / 4; }
  };

  double weight(int x, int y) const {
    return weights_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x)];
  }
  bool nearest() const { return filter_ == ImageFilter::kNearest; }
  Span span(int cell, int texels) const;
  Corners corners(int column, int row) const;
  const double* columns(int row) const {
    return columns_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(across_ + 1);
  }

  int width_, height_;
  ImageFilter filter_;
  ImageBorder border_;
  int across_, down_;  ///< numbers of cells
  std::vector<double> weights_;
  std::vector<double> row_densities_;  ///< measure over height of each row of cells
  std::vector<double> columns_;        ///< cumulative sums within each row of cells, from 0
  std::vector<double> rows_;           ///< cumulative sums of rows, from 0
};

}  // namespace lucerna
