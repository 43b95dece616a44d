// A picture thrown from a point: what it shows in a direction, its integral over directions, and
// directions drawn by its luminance.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <memory>
#include <optional>

#include "lights/pictures/image.h"
#include "lights/pictures/image_distribution.h"
#include "lights/sampling/sampling.h"

namespace lucerna {

struct ProjectedPictureParams {
  std::shared_ptr<const Image> image{};        ///< null: value 1 all over
  ImageFilter filter = ImageFilter::kNearest;  ///< the border goes on
  double fov_rad{};                            ///< full angle of its shorter side, (0, pi)
  double aspect = 1;                           ///< width over height, positive
};

/// The picture hangs in the plane z = 1, its middle on the axis, in which its shorter half side is
/// tan(fov / 2); x leads to its right edge and y to its upper one.  Directions are in these axes.
/// Immutable, shared by the lights that use it.  [Pharr23, 12.2.2]
class ProjectedPicture {
 public:
  /// Errors: fov or aspect out of their domain, also where the picture then has no solid angle or
  /// no side that a double holds.
  static absl::StatusOr<std::shared_ptr<const ProjectedPicture>> create(
      const ProjectedPictureParams& params);

  /// The point of the closed unit square, (0, 0) the upper left corner, that the direction `w`
  /// of any length but 0 leads through; nothing beside the picture and behind it.
  std::optional<Vec2<double>> find(const Vec3<double>& w) const;
  /// At a point of the unit square.
  Rgb<double> lookup(Vec2<double> p) const;

  /// The integral of the picture's value over directions [sr].  Nearest filter: the sum over texels
  /// of value times solid angle, each right to the last digits.  Bilinear: cell by cell
  /// between centres by Gauss's rule of such order that it is off by less than 1e-14 of itself.
  Rgb<double> integral_sr() const { return integral_; }
  /// A bound on the error of `integral_sr`, of itself: 0 where it is exact, roundings left out.
  double relative_error() const;
  /// The same as pbrt-v4 sums it: a texel's solid angle is its area in the plane times cos^3 at its
  /// centre.
  Rgb<double> integral_by_centres_sr() const { return integral_by_centres_; }

  /// A unit vector.  Density proportional to the luminance for the nearest filter, where a texel is
  /// larger than 1e-5 sr (in smaller ones it varies with cos^-3); for the bilinear one a cell by
  /// its share of the integral, in it bilinear in coordinates that keep solid angle.
  Vec3<double> sample(Vec2<double> u) const;
  /// Its density [1/sr] at a vector of any length but 0; 0 beside the picture.
  double per_sr(const Vec3<double>& w) const;
  /// Black all over.
  bool empty() const { return !(cells_.integral() > 0); }

  const ProjectedPictureParams& params() const { return params_; }
  /// Half sides in the plane.
  Vec2<double> half() const { return half_; }
  /// Of the largest texel in each channel.
  Rgb<double> brightest() const { return brightest_; }
  /// Of what is not the image.
  std::size_t bytes() const { return sizeof(*this) + cells_.bytes(); }

 private:
  /// A texel, or for the bilinear filter a square between centres (halved at the border), in the
  /// plane with y downwards as rows go.
  struct Cell {
    double x0, x1, y0, y1;
    BilinearWeights luminance;  ///< at its corners
  };
  ProjectedPicture(const ProjectedPictureParams& params, std::shared_ptr<const Image> image,
                   Vec2<double> half);
  bool nearest() const { return params_.filter == ImageFilter::kNearest; }
  int across() const { return image_->width() + (nearest() ? 0 : 1); }
  int down() const { return image_->height() + (nearest() ? 0 : 1); }
  /// Where cell `i` of `n` texels begins, in [-half, half].
  double edge(int i, int n, double half) const;
  /// The side of cell `i` of `n` texels.
  struct Stretch {
    double middle, half;
  };
  Stretch stretch(int i, int n, double half) const;
  Rgb<double> corner(int column, int row) const;
  Cell cell(int column, int row) const;
  std::vector<double> integrate_texels();
  std::vector<double> integrate_cells();
  void sum_by_centres();

  ProjectedPictureParams params_;
  std::shared_ptr<const Image> image_;  ///< one white texel where there is none
  Vec2<double> half_;
  Rgb<double> integral_, integral_by_centres_, brightest_;
  ImageDistribution cells_;  ///< which cell, by its share of the integral of luminance
};

}  // namespace lucerna
