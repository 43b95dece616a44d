#include "lights/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "lights/gauss.h"

namespace lucerna {
namespace {

/// Cells of one axis: texels for the nearest filter, else the spaces between their centres, at the
/// borders halves.
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
  Band band(int cell) const {
    const double n = texels;
    if (nearest) return {cell / n, 1 / n, (texels - 1 - cell) / n};
    const bool first = cell == 0, last = cell == texels;
    return {first ? 0 : (cell - 0.5) / n, first || last ? 0.5 / n : 1 / n,
            last ? 0 : (texels - 0.5 - cell) / n};
  }
  /// The texels that a cell lies between, and how much of the second there is at a coordinate.
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

using Polygon = std::vector<Vec2<double>>;

/// What of `in` has sign * (coordinate `axis`) not less than sign * `at`.  [Sutherland74]
void clip(const Polygon& in, int axis, double at, double sign, Polygon& out) {
  out.clear();
  const auto inside_by = [&](const Vec2<double>& p) {
    return sign * ((axis == 0 ? p.x : p.y) - at);
  };
  for (std::size_t i = 0; i < in.size(); ++i) {
    const Vec2<double>& a = in[i];
    const Vec2<double>& b = in[(i + 1) % in.size()];
    const double da = inside_by(a), db = inside_by(b);
    if (da >= 0) out.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      const double s = da / (da - db);
      Vec2<double> cut{a.x + (b.x - a.x) * s, a.y + (b.y - a.y) * s};
      (axis == 0 ? cut.x : cut.y) = at;
      out.push_back(cut);
    }
  }
}

/// The mean over the points of a triangle whose (u, v) lie on a line.  Those that lie at a place of
/// it grow in number from either end to where the third corner is.
Rgb<double> mean_over_line(const Picture& picture, const std::array<Vec2<double>, 3>& uv) {
  const auto squared = [&](std::size_t i, std::size_t j) {
    const double x = uv[j].x - uv[i].x, y = uv[j].y - uv[i].y;
    return x * x + y * y;
  };
  std::size_t i = 0;  // where the longest edge begins
  for (std::size_t k = 1; k < 3; ++k)
    if (squared(k, (k + 1) % 3) > squared(i, (i + 1) % 3)) i = k;
  const Vec2<double> from = uv[i], third = uv[(i + 2) % 3];
  const Vec2<double> along{uv[(i + 1) % 3].x - from.x, uv[(i + 1) % 3].y - from.y};
  const double length2 = along.x * along.x + along.y * along.y;
  if (!(length2 > 0)) return picture.at(from);
  const double most =
      std::clamp(((third.x - from.x) * along.x + (third.y - from.y) * along.y) / length2, 0.0, 1.0);

  std::vector<double> stops{0, most, 1};
  const auto add_edges = [&stops](const Cells& cells, double begin, double slope) {
    if (slope == 0) return;
    for (int cell = 1; cell < cells.count(); ++cell)
      if (const double t = (cells.begin(cell) - begin) / slope; t > 0 && t < 1) stops.push_back(t);
  };
  add_edges(columns(picture), from.x, along.x);
  add_edges(rows(picture), 1 - from.y, -along.y);
  std::sort(stops.begin(), stops.end());

  Rgb<double> mean;
  const double node = 0.5 / std::sqrt(3.0);  // two Gauss points: a cubic in each piece
  for (std::size_t k = 1; k < stops.size(); ++k) {
    const double begin = stops[k - 1], width = stops[k] - begin;
    if (!(width > 0)) continue;
    for (const double at : {0.5 - node, 0.5 + node}) {
      const double t = begin + width * at;
      const double density = t < most ? 2 * t / most : 2 * (1 - t) / (1 - most);
      mean += picture.at({from.x + along.x * t, from.y + along.y * t}) * (density * width / 2);
    }
  }
  return mean;
}

}  // namespace

Rgb<double> Picture::brightest() const {
  Rgb<double> most;
  for (int y = 0; y < image->height(); ++y)
    for (int x = 0; x < image->width(); ++x) {
      const Rgb<double> t(image->texel(x, y));
      most = {std::max(most.r, t.r), std::max(most.g, t.g), std::max(most.b, t.b)};
    }
  return most;
}

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

Rgb<double> mean_over_rows(const Picture& picture,
                           const std::function<BandArea(const Band&)>& area_of) {
  const Image& image = *picture.image;
  std::vector<Rgb<double>> row_means;
  for (int y = 0; y < image.height(); ++y) {
    Rgb<double> sum;
    for (int x = 0; x < image.width(); ++x) sum += Rgb<double>(image.texel(x, y));
    row_means.push_back(sum / double(image.width()));
  }
  const Cells cells = rows(picture);
  Rgb<double> mean;
  for (int cell = 0; cell < cells.count(); ++cell) {
    const BandArea area = area_of(cells.band(cell));
    const auto upper = static_cast<std::size_t>(cells.first(cell));
    const auto lower = static_cast<std::size_t>(cells.second(cell));
    if (upper == lower) {
      mean += row_means[upper] * area.share;
    } else {
      // The lower one's part grows from 0 to 1.
      mean += row_means[upper] * ((area.share - area.tilt) / 2) +
              row_means[lower] * ((area.share + area.tilt) / 2);
    }
  }
  return mean;
}

Rgb<double> mean_over_triangle(const Picture& picture, const std::array<Vec2<double>, 3>& uv) {
  // In the picture's own coordinates, y downwards.
  Polygon triangle;
  for (const Vec2<double>& p : uv) triangle.push_back({p.x, 1 - p.y});
  const auto twice_area = [](const Vec2<double>& a, const Vec2<double>& b, const Vec2<double>& c) {
    return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  };
  const double whole = twice_area(triangle[0], triangle[1], triangle[2]);
  double longest2 = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = uv[(i + 1) % 3].x - uv[i].x, y = uv[(i + 1) % 3].y - uv[i].y;
    longest2 = std::max(longest2, x * x + y * y);
  }
  // Polygons would be cut from what rounding leaves of such a triangle's width.
  if (!(std::fabs(whole) > 1e-9 * longest2)) return mean_over_line(picture, uv);
  const Cells across = columns(picture), down = rows(picture);
  const auto extent = [&](auto&& coordinate) {
    const double a = coordinate(triangle[0]), b = coordinate(triangle[1]),
                 c = coordinate(triangle[2]);
    return std::pair{std::min({a, b, c}), std::max({a, b, c})};
  };
  const auto [x0, x1] = extent([](const Vec2<double>& p) { return p.x; });
  const auto [y0, y1] = extent([](const Vec2<double>& p) { return p.y; });

  // The bilinear function of a cell is of degree 2: the middles of a triangle's edges integrate it.
  const auto value = [&](int column, int row, const Vec2<double>& p) {
    const double sx = across.share(column, p.x), sy = down.share(row, p.y);
    const auto texel = [&](int x, int y) { return Rgb<double>(picture.image->texel(x, y)); };
    const auto line = [&](int y) {
      return texel(across.first(column), y) * (1 - sx) + texel(across.second(column), y) * sx;
    };
    return line(down.first(row)) * (1 - sy) + line(down.second(row)) * sy;
  };
  Rgb<double> sum;
  Polygon a, band, b, part;
  for (int row = down.at(y0); row <= down.at(y1); ++row) {
    // The cells at the border go on beyond it.
    a = triangle;
    if (row > 0) clip(triangle, 1, down.begin(row), 1, a);
    band = a;
    if (row + 1 < down.count()) clip(a, 1, down.end(row), -1, band);
    if (band.size() < 3) continue;
    for (int column = across.at(x0); column <= across.at(x1); ++column) {
      b = band;
      if (column > 0) clip(band, 0, across.begin(column), 1, b);
      part = b;
      if (column + 1 < across.count()) clip(b, 0, across.end(column), -1, part);
      for (std::size_t i = 2; i < part.size(); ++i) {
        const Vec2<double>&p = part[0], &q = part[i - 1], &r = part[i];
        const auto middle = [](const Vec2<double>& s, const Vec2<double>& t) {
          return Vec2<double>{(s.x + t.x) / 2, (s.y + t.y) / 2};
        };
        const Rgb<double> values = value(column, row, middle(p, q)) +
                                   value(column, row, middle(q, r)) +
                                   value(column, row, middle(r, p));
        sum += values * (twice_area(p, q, r) / 3);
      }
    }
  }
  return sum / whole;
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

/// Those of `f` over the square by Legendre polynomials, [degree in u][degree in v]: exact for
/// polynomials of these degrees.
template <std::size_t kTerms>
Coefficients<kTerms> expand(const std::function<double(Vec2<double>)>& f) {
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

/// For each texel of an axis the integrals of its share in the picture times each polynomial.
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
    std::array<Rgb<double>, kTerms> row{};
    for (std::size_t x = 0; x < across.size(); ++x) {
      const Rgb<double> texel(picture.image->texel(static_cast<int>(x), static_cast<int>(y)));
      for (std::size_t i = 0; i < kTerms; ++i) row[i] += texel * across[x][i];
    }
    for (std::size_t i = 0; i < kTerms; ++i)
      for (std::size_t j = 0; j < kTerms; ++j) moments_[i][j] += row[i] * down[y][j];
  }
}

std::optional<PaintedArea> PictureMoments::times(const std::function<double(Vec2<double>)>& f,
                                                 double least) const {
  const Coefficients<kTerms> c = expand<kTerms>(f);
  const auto polynomial = [&c](Vec2<double> at) {
    const auto p = legendre<kTerms>(at.x), q = legendre<kTerms>(at.y);
    double sum = 0;
    for (std::size_t i = 0; i < kTerms; ++i)
      for (std::size_t j = 0; j < kTerms; ++j) sum += c[i][j] * p[i] * q[j];
    return sum;
  };
  PaintedArea sum;
  for (std::size_t i = 0; i < kTerms; ++i)
    for (std::size_t j = 0; j < kTerms; ++j) sum.m2 += moments_[i][j] * c[i][j];
  // f^2 - P^2 is a polynomial again, and no Legendre polynomial exceeds 1.
  double farthest = 0;
  const auto residual = expand<2 * kTerms - 1>([&](Vec2<double> at) {
    const double y = f(at), p = polynomial(at);
    farthest = std::max(farthest, std::fabs(y - p));
    return (y - p) * (y + p);
  });
  double bound = 0;
  for (const auto& row : residual)
    for (double r : row) bound += std::fabs(r);
  // What is left of a polynomial is rounding.
  if (farthest <= 1e-13 * c[0][0]) return sum;
  // Within it P has no zero: it is positive as its mean is, and |f - P| is that over f + P.
  if (!(bound < least * least && c[0][0] > 0)) return std::nullopt;
  sum.error_m2 =
      moments_[0][0].max_component() * bound / (least + std::sqrt(least * least - bound));
  return sum;
}

namespace {

/// Coordinates from `from` to `to`, so many that the picture has its extremes at them: both ends,
/// and each texel's middle in between.
void put_stops(double from, double to, int texels, std::vector<double>& stops) {
  stops = {from, to};
  const double first = std::ceil(std::clamp(from, 0.0, 1.0) * texels - 0.5);
  const double last = std::floor(std::clamp(to, 0.0, 1.0) * texels - 0.5);
  for (double texel = first; texel <= last; ++texel) stops.push_back((texel + 0.5) / texels);
}

}  // namespace

PaintedArea sum_over_points(const Picture& picture,
                            const std::function<Vec2<double>(Vec2<double>)>& uv,
                            const std::function<double(Vec2<double>)>& factor) {
  constexpr int kPoints = 256;
  constexpr double kCell = 1.0 / kPoints;
  Rgb<double> below, above;
  std::vector<double> us, downs;
  for (int j = 0; j < kPoints; ++j)
    for (int i = 0; i < kPoints; ++i) {
      const Vec2<double> middle{(i + 0.5) * kCell, (j + 0.5) * kCell};
      Vec2<double> lower = uv(middle), upper = lower;
      double most = 0;
      for (int k = 0; k < 4; ++k) {
        const Vec2<double> corner{(i + (k & 1)) * kCell, (j + (k >> 1)) * kCell};
        const Vec2<double> at = uv(corner);
        lower = {std::min(lower.x, at.x), std::min(lower.y, at.y)};
        upper = {std::max(upper.x, at.x), std::max(upper.y, at.y)};
        most = std::max(most, factor(corner));
      }
      // Convex: opposite points have a mean that is not below the middle.
      const double least = std::max(0.0, 2 * factor(middle) - most);
      Rgb<double> dark(std::numeric_limits<double>::infinity()), bright;
      put_stops(lower.x, upper.x, picture.image->width(), us);
      put_stops(1 - upper.y, 1 - lower.y, picture.image->height(), downs);
      for (double u : us)
        for (double down : downs) {
          const Rgb<double> at = picture.at({u, 1 - down});
          dark = {std::min(dark.r, at.r), std::min(dark.g, at.g), std::min(dark.b, at.b)};
          bright = {std::max(bright.r, at.r), std::max(bright.g, at.g), std::max(bright.b, at.b)};
        }
      below += dark * (least * kCell * kCell);
      above += bright * (most * kCell * kCell);
    }
  return {(below + above) * 0.5, (above * 0.5 - below * 0.5).max_component()};
}

}  // namespace lucerna
