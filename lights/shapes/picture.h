// Pictures on surfaces: how they lie there, and their integrals over area.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lights/pictures/image.h"
#include "lights/shapes/shape.h"

namespace lucerna {

/// A picture by the coordinates (u, v) of a surface: u to the right, v upwards, from 0 to 1.
/// Beyond its border the border goes on.
struct Picture {
  std::shared_ptr<const Image> image;  ///< not null
  ImageFilter filter = ImageFilter::kBilinear;
  std::string name;  ///< as ListLights tells it

  Rgb<double> at(Vec2<double> uv) const {
    return image->lookup({uv.x, 1 - uv.y}, filter, ImageBorder::kClamp);
  }
  /// The largest value of each channel.
  Rgb<double> brightest() const;
};

/// A picture integrated over a surface's area.
struct PaintedArea {
  Rgb<double> m2;
  double error_m2{};  ///< bound on the error of each channel of `m2`; 0 where it is exact
};

/// The mean over a surface of which `area_of` tells what a band covers.  Exact.
Rgb<double> mean_over_rows(const Picture& picture,
                           const std::function<BandArea(const Band&)>& area_of);
/// The rows of cells on which a picture is linear from the upper edge to the lower one, from the
/// top: texels for the nearest filter, else the spaces between their centres, at the borders
/// halves.
std::vector<Band> rows_of_cells(const Picture& picture);
/// The one of them that holds the coordinate `y`, from the top.
Band row_of_cells(const Picture& picture, double y);

/// The mean over the points of a triangle whose corners have these (u, v).  Exact: the triangle is
/// cut into polygons on which the picture is bilinear, however thin it is in (u, v), and where
/// these lie on a line or in one point too.
Rgb<double> mean_over_triangle(const Picture& picture, const std::array<Vec2<double>, 3>& uv);

/// The integral of `factor`(s, t) times the picture at `uv`(s, t) over the square of (s, t): the
/// middle between a lower and an upper bound, summed over 256 by 256 cells of what the picture and
/// the factor reach in each.  `uv` is bilinear and `factor` convex along lines.
PaintedArea sum_over_points(const Picture& picture,
                            const std::function<Vec2<double>(Vec2<double>)>& uv,
                            const std::function<double(Vec2<double>)>& factor);

/// For integrals against smooth functions of (u, v): the picture's moments with the Legendre
/// polynomials up to degree 8 in each coordinate, which are exact.
class PictureMoments {
 public:
  explicit PictureMoments(const Picture& picture);
  /// The integral of the picture times `f` over the square.  `f` is not less than `least`, and its
  /// square a polynomial of degree 16 or less in each coordinate, as of an area element.  Exact
  /// where `f` is a polynomial of degree 8; nothing where no bound on the error is known, because
  /// `f` varies much.
  std::optional<PaintedArea> times(const std::function<double(Vec2<double>)>& f,
                                   double least) const;

 private:
  static constexpr int kTerms = 9;
  std::array<std::array<Rgb<double>, kTerms>, kTerms> moments_;  ///< [degree in u][degree in v]
};

}  // namespace lucerna
