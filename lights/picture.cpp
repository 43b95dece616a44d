#include "lights/picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace lucerna {
namespace {

/// Nodes and weights for the integral from 0 to 1 of polynomials up to degree 17.
struct Gauss {
  static constexpr int kNodes = 9;
  std::array<double, kNodes> node, weight;

  Gauss() {
    // The roots of the Legendre polynomial by Newton's method.  [DLMF, 3.5(v), 18.16(ii)]
    for (int k = 0; k < kNodes; ++k) {
      double x = std::cos(std::numbers::pi * (k + 0.75) / (kNodes + 0.5)), slope = 0;
      for (int step = 0; step < 20; ++step) {
        double before = 1, p = x;
        for (int n = 2; n <= kNodes; ++n)
          before = std::exchange(p, ((2 * n - 1) * x * p - (n - 1) * before) / n);
        slope = kNodes * (x * p - before) / (x * x - 1);
        x -= p / slope;
      }
      node[static_cast<std::size_t>(k)] = (1 + x) / 2;
      weight[static_cast<std::size_t>(k)] = 1 / ((1 - x * x) * slope * slope);
    }
  }
};

const Gauss& gauss() {
  static const Gauss rule;
  return rule;
}

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

Rgb<double> mean_over_rows(const Picture& picture, const std::function<double(double)>& area_below,
                           const std::function<double(double)>& area_below_integral) {
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
    // In v, which runs upwards: the cell's lower edge comes first.
    const double v0 = 1 - cells.end(cell), v1 = 1 - cells.begin(cell);
    const double measure = area_below(v1) - area_below(v0);
    const auto lower = static_cast<std::size_t>(cells.second(cell));
    const auto upper = static_cast<std::size_t>(cells.first(cell));
    // The integral of the share of the way from v0 to v1, by parts.
    const double of_upper =
        lower == upper
            ? 0
            : area_below(v1) - (area_below_integral(v1) - area_below_integral(v0)) / (v1 - v0);
    mean += row_means[lower] * (measure - of_upper) + row_means[upper] * of_upper;
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
  if (!(std::fabs(whole) > 1e-30))
    return picture.at({(uv[0].x + uv[1].x + uv[2].x) / 3, (uv[0].y + uv[1].y + uv[2].y) / 3});
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

/// The Legendre polynomials of degrees 0 to 8, shifted to [0, 1].  [DLMF, 18.9(i)]
std::array<double, 9> legendre(double x) {
  std::array<double, 9> p{1, 2 * x - 1};
  for (std::size_t n = 2; n < p.size(); ++n) {
    const auto m = static_cast<double>(n);
    p[n] = ((2 * m - 1) * (2 * x - 1) * p[n - 1] - (m - 1) * p[n - 2]) / m;
  }
  return p;
}

/// For each texel of an axis the integrals of its share in the picture times each polynomial.
std::vector<std::array<double, 9>> texel_moments(const Cells& cells, bool upwards) {
  std::vector<std::array<double, 9>> moments(static_cast<std::size_t>(cells.texels));
  const Gauss& rule = gauss();
  for (int cell = 0; cell < cells.count(); ++cell) {
    const double begin = cells.begin(cell), width = cells.end(cell) - begin;
    for (std::size_t k = 0; k < rule.node.size(); ++k) {
      const double at = begin + width * rule.node[k], weight = width * rule.weight[k];
      const double share = cells.share(cell, at);
      const auto p = legendre(upwards ? 1 - at : at);
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

PaintedArea PictureMoments::times(const std::function<double(Vec2<double>)>& f) const {
  const Gauss& rule = gauss();
  double coefficients[kTerms][kTerms]{};
  for (std::size_t a = 0; a < rule.node.size(); ++a)
    for (std::size_t b = 0; b < rule.node.size(); ++b) {
      const double value = rule.weight[a] * rule.weight[b] * f({rule.node[a], rule.node[b]});
      const auto p = legendre(rule.node[a]), q = legendre(rule.node[b]);
      for (std::size_t i = 0; i < kTerms; ++i)
        for (std::size_t j = 0; j < kTerms; ++j)
          coefficients[i][j] += double((2 * i + 1) * (2 * j + 1)) * value * p[i] * q[j];
    }
  PaintedArea sum;
  double tail = 0;
  for (std::size_t i = 0; i < kTerms; ++i)
    for (std::size_t j = 0; j < kTerms; ++j) {
      sum.m2 += moments_[i][j] * coefficients[i][j];
      if (i >= kTerms - 2 || j >= kTerms - 2) tail += std::fabs(coefficients[i][j]);
    }
  // What is left of polynomials of lower degree is rounding.
  if (tail > 1e-13 * coefficients[0][0]) sum.error_m2 = luminance(moments_[0][0]) * tail;
  return sum;
}

}  // namespace lucerna
