// Pictures on surfaces: their mapping and their integrals over area.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lights/pictures/image.h"

namespace lucerna {

/// A picture in the coordinates (u, v) of a surface: u to the right, v upwards, from 0 to 1.  The
/// border texels continue outside of the border.
struct Picture {
  std::shared_ptr<const Image> image;  ///< not null
  ImageFilter filter = ImageFilter::kBilinear;
  std::string name;  ///< name that ListLights reports

  Rgb at(Vec2 uv) const { return image->lookup({uv.x, 1 - uv.y}, filter, ImageBorder::kClamp); }
};

/// A band across a picture from side to side, in shares of its height, which add up to 1. All three
/// are stored, because differences would lose digits for thin bands.
struct Band {
  double above, height, below;
};

/// The part of a surface's area that a band of its picture covers.
struct BandArea {
  double share;  ///< of the whole
  double tilt;   ///< integral over the band, in shares, of a weight from -1 at its top to 1 at its
                 ///< bottom
};

/// A picture integrated over a surface's area.
struct PaintedArea {
  Rgb m2;
  double error_m2{};  ///< bound on the error of each channel of `m2`; 0 where it is exact
};

/// The mean of the picture over a surface.  `area_of` returns the area that a band covers.  Exact.
Rgb mean_over_rows(const Picture& picture, const std::function<BandArea(const Band&)>& area_of);
/// The rows of cells, from the top, in which a picture is linear from the upper edge to the lower
/// edge.  For the nearest filter they are the texels.  Otherwise they are the spaces between
/// centres of texels, and halves at the borders.
std::vector<Band> rows_of_cells(const Picture& picture);
/// The row that contains the coordinate `y`, from the top.
Band row_of_cells(const Picture& picture, double y);

/// The mean over the points of a triangle whose corners have these (u, v).  Exact: the triangle is
/// cut into polygons on which the picture is bilinear.  It is also exact for triangles that are
/// thin in (u, v), or that lie on a line or in one point.
Rgb mean_over_triangle(const Picture& picture, const std::array<Vec2, 3>& uv);

/// The integral of `factor`(s, t) times the picture at `uv`(s, t) over the square of (s, t).  It is
/// the middle between a lower and an upper bound.  The bounds are sums over 256 by 256 cells, from
/// the range of picture and factor in each cell.  `uv` is bilinear and `factor` convex along lines.
PaintedArea sum_over_points(const Picture& picture, const std::function<Vec2(Vec2)>& uv,
                            const std::function<double(Vec2)>& factor);

/// The picture's moments with the Legendre polynomials up to degree 8 in each coordinate, exact.
/// They give integrals against smooth functions of (u, v).
class PictureMoments {
 public:
  explicit PictureMoments(const Picture& picture);
  /// The integral of the picture times `f` over the square. `f` is at least `least`. Its square is
  /// a polynomial of degree 16 or less in each coordinate, like the square of an area element.
  /// Exact if `f` is a polynomial of degree 8.  Nothing if `f` varies so much that the error has no
  /// bound.
  std::optional<PaintedArea> times(const std::function<double(Vec2)>& f, double least) const;

 private:
  static constexpr int kTerms = 9;
  std::array<std::array<Rgb, kTerms>, kTerms> moments_;  ///< [degree in u][degree in v]
};

}  // namespace lucerna
