#include "lights/shapes/shape_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "lights/maths/gauss.h"
#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

/// Cells of one axis. For the nearest filter they are texels. Otherwise they are the spaces between
/// centres of texels, and halves at the borders.
struct Cells {
  int texels;
  bool nearest;

  int count() const { return nearest ? texels : texels + 1; }
  double begin(int cell) const {
    if (nearest) return double{1} * cell / texels;
    return cell == 0 ? 0 : (cell - 0.5) / texels;
  }
  double end(int cell) const {
    if (nearest) return (cell + 1.0) / texels;
    return cell == texels ? 1 : (cell + 0.5) / texels;
  }
  /// The beginning of a cell other than the first, in texels.
  double line(int cell) const { return nearest ? cell : cell - 0.5; }
  Band band(int cell) const {
    const double n = texels;
    if (nearest) return {cell / n, 1 / n, (texels - 1 - cell) / n};
    const bool first = cell == 0, last = cell == texels;
    return {first ? 0 : (cell - 0.5) / n, first || last ? 0.5 / n : 1 / n,
            last ? 0 : (texels - 0.5 - cell) / n};
  }
  /// The texels on both sides of a cell, and the weight of the second at a coordinate.
  int first(int cell) const { return nearest ? cell : std::max(cell - 1, 0); }
  int second(int cell) const { return nearest ? cell : std::min(cell, texels - 1); }
  double share(int cell, double at) const {
    return nearest ? 0 : std::clamp(at * texels - 0.5 - (cell - 1), 0.0, 1.0);
  }
  /// The cell of a coordinate.
  int at(double coordinate) const {
    const double scaled = std::clamp(coordinate, 0.0, 1.0) * texels + (nearest ? 0 : 0.5);
    return std::min(static_cast<int>(scaled), count() - 1);
  }
};

Cells columns(const Picture& p) { return {p.image->width(), p.filter == ImageFilter::kNearest}; }
Cells rows(const Picture& p) { return {p.image->height(), p.filter == ImageFilter::kNearest}; }

/// Points of a triangle in barycentric coordinates.  In these coordinates no triangle is thin, and
/// points on an edge have a coordinate of exactly 0.
using Polygon = std::vector<Vec3>;

/// The part of `in` on the upper side (`sign` 1) or the lower side (-1) of a line.  `off` is the
/// distance of each corner from the line.  [Sutherland74]
void clip(const Polygon& in, const Vec3& off, double sign, Polygon& out) {
  out.clear();
  StopPoll poll;
  for (std::size_t i = 0; i < in.size(); ++i, poll()) {
    const Vec3& a = in[i];
    const Vec3& b = in[(i + 1) % in.size()];
    const double da = sign * dot(a, off), db = sign * dot(b, off);
    if (da >= 0) out.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) out.push_back(a + (b - a) * (da / (da - db)));
  }
}

}  // namespace

std::vector<Band> rows_of_cells(const Picture& picture) {
  const Cells cells = rows(picture);
  std::vector<Band> bands;
  for (int cell = 0; cell < cells.count(); ++cell) bands.push_back(cells.band(cell));
  return bands;
}

Band row_of_cells(const Picture& picture, double y) {
  const Cells cells = rows(picture);
  return cells.band(cells.at(y));
}

Rgb mean_over_rows(const Picture& picture, const std::function<BandArea(const Band&)>& area_of) {
  const Image& image = *picture.image;
  std::vector<Rgb> row_means;
  StopPoll poll;
  for (int y = 0; y < image.height(); ++y) {
    Rgb sum;
    for (int x = 0; x < image.width(); ++x, poll()) sum += Rgb(image.texel(x, y));
    row_means.push_back(sum / double(image.width()));
  }
  const Cells cells = rows(picture);
  Rgb mean;
  for (int cell = 0; cell < cells.count(); ++cell, poll()) {
    const BandArea area = area_of(cells.band(cell));
    const auto upper = static_cast<std::size_t>(cells.first(cell));
    const auto lower = static_cast<std::size_t>(cells.second(cell));
    if (upper == lower) {
      mean += row_means[upper] * area.share;
    } else {
      // The weight of the lower row grows from 0 to 1.
      mean += row_means[upper] * ((area.share - area.tilt) / 2) +
              row_means[lower] * ((area.share + area.tilt) / 2);
    }
  }
  return mean;
}

Rgb mean_over_triangle(const Picture& picture, const std::array<Vec2, 3>& uv) {
  // In the picture's own coordinates, y downwards.
  const Vec3 x{uv[0].x, uv[1].x, uv[2].x}, v{uv[0].y, uv[1].y, uv[2].y};
  const Vec3 y{1 - v.x, 1 - v.y, 1 - v.z};
  const Cells across = columns(picture), down = rows(picture);
  // The signed distance of the corners from the line where a cell begins.  The product of (u, v) in
  // float and a number of texels is exact, so there is only one rounding.
  const auto beyond_column = [&](int cell) {
    const double at = across.line(cell), n = across.texels;
    return Vec3{x.x * n - at, x.y * n - at, x.z * n - at};
  };
  const auto below_row = [&](int cell) {
    const double from_below = down.texels - down.line(cell), n = down.texels;
    return Vec3{from_below - v.x * n, from_below - v.y * n, from_below - v.z * n};
  };
  // The bilinear function of a cell has degree 2, so the mean over the middles of a triangle's
  // edges is exact.
  const auto value = [&](int column, int row, const Vec3& p) {
    const double sx = across.share(column, dot(p, x)), sy = down.share(row, dot(p, y));
    const auto texel = [&](int i, int j) { return Rgb(picture.image->texel(i, j)); };
    const auto line = [&](int j) {
      return texel(across.first(column), j) * (1 - sx) + texel(across.second(column), j) * sx;
    };
    return line(down.first(row)) * (1 - sy) + line(down.second(row)) * sy;
  };
  // Twice the area in barycentric coordinates: 1 for the whole triangle.
  const auto twice_area = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b.y - a.y) * (c.z - a.z) - (c.y - a.y) * (b.z - a.z);
  };
  const int last_row = down.at(std::max({y.x, y.y, y.z}));
  const int first_column = across.at(std::min({x.x, x.y, x.z}));
  const int last_column = across.at(std::max({x.x, x.y, x.z}));
  const Polygon triangle{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Rgb sum;
  Polygon a, band, b, part;
  StopPoll poll;
  for (int row = down.at(std::min({y.x, y.y, y.z})); row <= last_row; ++row) {
    // The cells at the border continue outside of it.
    a = triangle;
    if (row > 0) clip(triangle, below_row(row), 1, a);
    band = a;
    if (row + 1 < down.count()) clip(a, below_row(row + 1), -1, band);
    if (band.size() < 3) continue;
    double left = dot(band[0], x), right = left;
    for (const Vec3& p : band) {
      left = std::min(left, dot(p, x));
      right = std::max(right, dot(p, x));
    }
    // Visit one more cell on either side, because these numbers are rounded.  But do not leave the
    // cells of the corners: that would count a triangle on the line between two cells twice.
    const int end = std::min(across.at(right) + 1, last_column);
    for (int column = std::max(across.at(left) - 1, first_column); column <= end;
         ++column, poll()) {
      b = band;
      if (column > 0) clip(band, beyond_column(column), 1, b);
      part = b;
      if (column + 1 < across.count()) clip(b, beyond_column(column + 1), -1, part);
      for (std::size_t i = 2; i < part.size(); ++i) {
        const Vec3 &p = part[0], &q = part[i - 1], &r = part[i];
        const Rgb values = value(column, row, (p + q) * 0.5) + value(column, row, (q + r) * 0.5) +
                           value(column, row, (r + p) * 0.5);
        sum += values * (twice_area(p, q, r) / 3);
      }
    }
  }
  return sum;
}

namespace {

/// The Legendre polynomials of degrees 0 to kTerms - 1, shifted to [0, 1].  [DLMF, 18.9(i)]
template <std::size_t kTerms>
std::array<double, kTerms> legendre(double x) {
  std::array<double, kTerms> p{1, 2 * x - 1};
  for (std::size_t n = 2; n < p.size(); ++n) {
    const auto m = static_cast<double>(n);
    p[n] = ((2 * m - 1) * (2 * x - 1) * p[n - 1] - (m - 1) * p[n - 2]) / m;
  }
  return p;
}

template <std::size_t kTerms>
using Coefficients = std::array<std::array<double, kTerms>, kTerms>;

/// The moments of `f` over the square by Legendre polynomials, [degree in u][degree in v].  Exact
/// for polynomials of these degrees.
template <std::size_t kTerms>
Coefficients<kTerms> expand(const std::function<double(Vec2)>& f) {
  const Gauss<kTerms>& rule = gauss<kTerms>();
  Coefficients<kTerms> c{};
  for (std::size_t b = 0; b < kTerms; ++b) {
    std::array<double, kTerms> row{};
    for (std::size_t a = 0; a < kTerms; ++a) {
      const double value = rule.weight[a] * f({rule.node[a], rule.node[b]});
      const auto p = legendre<kTerms>(rule.node[a]);
      for (std::size_t i = 0; i < kTerms; ++i) row[i] += double(2 * i + 1) * value * p[i];
    }
    const auto q = legendre<kTerms>(rule.node[b]);
    for (std::size_t i = 0; i < kTerms; ++i)
      for (std::size_t j = 0; j < kTerms; ++j)
        c[i][j] += double(2 * j + 1) * rule.weight[b] * row[i] * q[j];
  }
  return c;
}

/// For each texel of an axis, the integrals of its weight in the picture times each polynomial.
std::vector<std::array<double, 9>> texel_moments(const Cells& cells, bool upwards) {
  std::vector<std::array<double, 9>> moments(static_cast<std::size_t>(cells.texels));
  const Gauss<9>& rule = gauss<9>();
  for (int cell = 0; cell < cells.count(); ++cell) {
    const double begin = cells.begin(cell), width = cells.end(cell) - begin;
    for (std::size_t k = 0; k < rule.node.size(); ++k) {
      const double at = begin + width * rule.node[k], weight = width * rule.weight[k];
      const double share = cells.share(cell, at);
      const auto p = legendre<9>(upwards ? 1 - at : at);
      for (std::size_t n = 0; n < p.size(); ++n) {
        moments[static_cast<std::size_t>(cells.first(cell))][n] += weight * (1 - share) * p[n];
        moments[static_cast<std::size_t>(cells.second(cell))][n] += weight * share * p[n];
      }
    }
  }
  return moments;
}

}  // namespace

PictureMoments::PictureMoments(const Picture& picture) : moments_{} {
  const auto across = texel_moments(columns(picture), false);
  const auto down = texel_moments(rows(picture), true);
  for (std::size_t y = 0; y < down.size(); ++y) {
    std::array<Rgb, kTerms> row{};
    for (std::size_t x = 0; x < across.size(); ++x) {
      const Rgb texel(picture.image->texel(static_cast<int>(x), static_cast<int>(y)));
      for (std::size_t i = 0; i < kTerms; ++i) row[i] += texel * across[x][i];
    }
    for (std::size_t i = 0; i < kTerms; ++i)
      for (std::size_t j = 0; j < kTerms; ++j) moments_[i][j] += row[i] * down[y][j];
  }
}

std::optional<PaintedArea> PictureMoments::times(const std::function<double(Vec2)>& f,
                                                 double least) const {
  const Coefficients<kTerms> c = expand<kTerms>(f);
  const auto polynomial = [&c](Vec2 at) {
    const auto p = legendre<kTerms>(at.x), q = legendre<kTerms>(at.y);
    double sum = 0;
    for (std::size_t i = 0; i < kTerms; ++i)
      for (std::size_t j = 0; j < kTerms; ++j) sum += c[i][j] * p[i] * q[j];
    return sum;
  };
  PaintedArea sum;
  for (std::size_t i = 0; i < kTerms; ++i)
    for (std::size_t j = 0; j < kTerms; ++j) sum.m2 += moments_[i][j] * c[i][j];
  // f^2 - P^2 is a polynomial too.  Legendre polynomials do not exceed 1, so the sum of its
  // coefficients bounds it.
  double farthest = 0;
  const auto residual = expand<2 * kTerms - 1>([&](Vec2 at) {
    const double y = f(at), p = polynomial(at);
    farthest = std::max(farthest, std::fabs(y - p));
    return (y - p) * (y + p);
  });
  double bound = 0;
  for (const auto& row : residual)
    for (double r : row) bound += std::fabs(r);
  // Differences this small are rounding.
  if (farthest <= 1e-13 * c[0][0]) return sum;
  // The bound excludes a zero of P.  P is positive because its mean is, and |f - P| = |f^2 - P^2| /
  // (f + P).
  if (!(bound < least * least && c[0][0] > 0)) return std::nullopt;
  sum.error_m2 =
      moments_[0][0].max_component() * bound / (least + std::sqrt(least * least - bound));
  return sum;
}

namespace {

/// Coordinates from `from` to `to` at which the picture has its extremes: both ends, and the middle
/// of each texel between.
void put_stops(double from, double to, int texels, std::vector<double>& stops) {
  stops = {from, to};
  const double first = std::ceil(std::clamp(from, 0.0, 1.0) * texels - 0.5);
  const double last = std::floor(std::clamp(to, 0.0, 1.0) * texels - 0.5);
  for (double texel = first; texel <= last; ++texel) stops.push_back((texel + 0.5) / texels);
}

}  // namespace

PaintedArea sum_over_points(const Picture& picture, const std::function<Vec2(Vec2)>& uv,
                            const std::function<double(Vec2)>& factor) {
  constexpr int kPoints = 256;
  constexpr double kCell = 1.0 / kPoints;
  Rgb below, above;
  std::vector<double> us, downs;
  for (int j = 0; j < kPoints; ++j)
    for (int i = 0; i < kPoints; ++i) {
      const Vec2 middle{(i + 0.5) * kCell, (j + 0.5) * kCell};
      Vec2 lower = uv(middle), upper = lower;
      double most = 0;
      for (int k = 0; k < 4; ++k) {
        const Vec2 corner{(i + (k & 1)) * kCell, (j + (k >> 1)) * kCell};
        const Vec2 at = uv(corner);
        lower = {std::min(lower.x, at.x), std::min(lower.y, at.y)};
        upper = {std::max(upper.x, at.x), std::max(upper.y, at.y)};
        most = std::max(most, factor(corner));
      }
      // The factor is convex: the mean of opposite points is not below the value at the middle.
      const double least = std::max(0.0, 2 * factor(middle) - most);
      Rgb dark(std::numeric_limits<double>::infinity()), bright;
      put_stops(lower.x, upper.x, picture.image->width(), us);
      put_stops(1 - upper.y, 1 - lower.y, picture.image->height(), downs);
      for (double u : us)
        for (double down : downs) {
          const Rgb at = picture.at({u, 1 - down});
          dark = {std::min(dark.r, at.r), std::min(dark.g, at.g), std::min(dark.b, at.b)};
          bright = {std::max(bright.r, at.r), std::max(bright.g, at.g), std::max(bright.b, at.b)};
        }
      below += dark * (least * kCell * kCell);
      above += bright * (most * kCell * kCell);
    }
  return {(below + above) * 0.5, (above * 0.5 - below * 0.5).max_component()};
}

}  // namespace lucerna
