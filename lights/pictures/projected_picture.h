// A picture projected from a point: its value in a direction, its integral over directions, and
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
  std::shared_ptr<const Image> image{};        ///< null: value 1 everywhere
  ImageFilter filter = ImageFilter::kNearest;  ///< the border texels continue
  double fov_rad{};                            ///< full angle of its shorter side, (0, pi)
  double aspect = 1;                           ///< width over height, positive
};

/// The picture lies in the plane z = 1 with its middle on the axis.  Half of its shorter side is
/// tan(fov / 2). x points to its right edge and y to its upper edge.  Directions are in these axes.
/// Immutable, so lights share it.  [Pharr23, 12.2.2]
class ProjectedPicture {
 public:
  /// Errors: fov or aspect out of their domain; a solid angle or a side of the picture that doubles
  /// cannot hold.
  static absl::StatusOr<std::shared_ptr<const ProjectedPicture>> create(
      const ProjectedPictureParams& params);

  /// The point of the closed unit square, (0, 0) the upper left corner, in the direction `w` of any
  /// length but 0.  Nothing for directions beside the picture or behind it.
  std::optional<Vec2> find(const Vec3& w) const;
  /// The value at a point of the unit square.
  Rgb lookup(Vec2 p) const;

  /// The integral of the picture's value over directions [sr].  Nearest filter: the sum over texels
  /// of value times solid angle, exact to rounding.  Bilinear filter: cell by cell between centres
  /// by Gauss's rule, with a relative error below 1e-14.
  Rgb integral_sr() const { return integral_; }
  /// A bound on the relative error of `integral_sr`, without roundings: 0 where it is exact.
  double relative_error() const;
  /// The same sum as in pbrt-v4: a texel's solid angle is its area in the plane times cos^3 at its
  /// centre.
  Rgb integral_by_centres_sr() const { return integral_by_centres_; }

  /// A unit vector.  With the nearest filter, its density is proportional to the luminance in
  /// texels larger than 1e-5 sr; in smaller texels it varies with cos^-3.  With the bilinear
  /// filter, a cell is chosen by its share of the integral.  Within the cell, the density is
  /// bilinear in coordinates that preserve solid angle.
  Vec3 sample(Vec2 u) const;
  /// Its density [1/sr] at a vector of any length but 0; 0 beside the picture.
  double per_sr(const Vec3& w) const;
  /// Whether the picture is black everywhere.
  bool empty() const { return !(cells_.integral() > 0); }

  const ProjectedPictureParams& params() const { return params_; }
  /// Half sides in the plane.
  Vec2 half() const { return half_; }
  /// The largest value in each channel.
  Rgb brightest() const { return brightest_; }
  /// Memory without the image.
  std::size_t bytes() const { return sizeof(*this) + cells_.bytes(); }

 private:
  /// A texel, or for the bilinear filter a square between centres (halved at the border).  In the
  /// plane, with y downwards like rows.
  struct Cell {
    double x0, x1, y0, y1;
    BilinearWeights luminance;  ///< at its corners
  };
  ProjectedPicture(const ProjectedPictureParams& params, std::shared_ptr<const Image> image,
                   Vec2 half);
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
  Rgb corner(int column, int row) const;
  Cell cell(int column, int row) const;
  std::vector<double> integrate_texels();
  std::vector<double> integrate_cells();
  void sum_by_centres();

  ProjectedPictureParams params_;
  std::shared_ptr<const Image> image_;  ///< one white texel if there is no image
  Vec2 half_;
  Rgb integral_, integral_by_centres_, brightest_;
  ImageDistribution cells_;  ///< chooses a cell by its share of the integral of luminance
};

}  // namespace lucerna
