#include "lights/pictures/projected_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "lights/maths/stop_poll.h"
#include "lights/sampling/spherical_rectangle.h"
#include "lights/sampling/spherical_triangle.h"

namespace lucerna {
namespace {

/// Solid angle over area of the plane z = 1: the cube of the cosine.
double sr_per_area(double x, double y) {
  const double cos = 1 / std::sqrt(1 + x * x + y * y);
  return cos * cos * cos;
}

struct Nodes {
  std::array<double, 5> at, weight;  ///< on [-1, 1]; the weights add up to 2
  int count;
};

/// Gauss's rules of three and five nodes.  [DLMF, 3.5(v)]
Nodes three_nodes() {
  const double x = std::sqrt(3.0 / 5);
  return {{-x, 0, x}, {5.0 / 9, 8.0 / 9, 5.0 / 9}, 3};
}
Nodes five_nodes() {
  const double root = 2 * std::sqrt(10.0 / 7);
  const double near = std::sqrt(5 - root) / 3, far = std::sqrt(5 + root) / 3;
  const double more = (322 + 13 * std::sqrt(70.0)) / 900, less = (322 - 13 * std::sqrt(70.0)) / 900;
  return {{-far, -near, 0, near, far}, {less, more, 128.0 / 225, more, less}, 5};
}

/// Integrals over solid angle of the four weights of bilinear interpolation in a cell.
struct Shares {
  double w00 = 0, w10 = 0, w01 = 0, w11 = 0;
};

/// Part of a cell, in coordinates of the plane (x, y) and of the cell (s, t).
struct Part {
  double x, y, half_x, half_y;  ///< middle and half sides
  double s, t, half_s, half_t;

  /// A whole cell.
  template <typename Stretch>
  Part(const Stretch& along_x, const Stretch& along_y)
      : x(along_x.middle),
        y(along_y.middle),
        half_x(along_x.half),
        half_y(along_y.half),
        s(0.5),
        t(0.5),
        half_s(0.5),
        half_t(0.5) {}
  /// Distance of the middle from the origin, which is at a distance of 1 from the plane.
  double distance() const { return std::sqrt(1 + x * x + y * y); }
};

/// Halves `p` until no half side of a part is longer than its distance times `longest`.  Calls
/// `visit(part, distance)` for each part.
template <typename Visit>
void for_each_part(const Part& p, double longest, const Visit& visit) {
  const double distance = p.distance();
  if (!(std::max(p.half_x, p.half_y) > longest * distance)) return visit(p, distance);
  for (const int side : {-1, 1}) {
    Part half = p;
    if (p.half_x >= p.half_y) {
      half.half_x /= 2, half.half_s /= 2;
      half.x += side * half.half_x, half.s += side * half.half_s;
    } else {
      half.half_y /= 2, half.half_t /= 2;
      half.y += side * half.half_y, half.t += side * half.half_t;
    }
    for_each_part(half, longest, visit);
  }
}

/// Largest half sides of parts, as shares of their distance, for three and five nodes.
///
/// In the complex plane, the integrand is analytic up to the distance r = sqrt(1 + x^2 + y^2). So n
/// nodes on [-a, a] have a relative error of about (2 r / a)^(-2 n).  This is 1e-16 for five nodes
/// at a = r / 20 and for three at a = r / 250.  [DLMF, 3.5(v)]
constexpr double kFine = 1.0 / 250, kCoarse = 1.0 / 20;

/// Calls `add(weight, s, t)` for each node of a part, with weights in solid angle [sr].
template <typename Add>
void for_each_node(const Part& p, const Nodes& nodes, const Add& add) {
  for (int j = 0; j < nodes.count; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const double y = p.y + p.half_y * nodes.at[at], t = p.t + p.half_t * nodes.at[at];
    for (int i = 0; i < nodes.count; ++i) {
      const auto along = static_cast<std::size_t>(i);
      const double x = p.x + p.half_x * nodes.at[along], s = p.s + p.half_s * nodes.at[along];
      add(nodes.weight[at] * nodes.weight[along] * sr_per_area(x, y) * p.half_x * p.half_y, s, t);
    }
  }
}

/// The solid angle of a cell [sr].  Nothing is computed as a difference: sums over corners lose all
/// digits of a cell that is small or grazing.  Small parts use three nodes.  Other parts use two
/// triangles, whose corners are less than a right angle apart.
double solid_angle(const Part& cell) {
  static const Nodes kThree = three_nodes();
  double sr = 0;
  for_each_part(cell, 0.5, [&sr](const Part& p, double distance) {
    if (std::max(p.half_x, p.half_y) <= kFine * distance)
      return for_each_node(p, kThree, [&sr](double weight, double, double) { sr += weight; });
    // Products of three coordinates above 1e102 overflow.
    const double unit = distance < 1e100 ? 1 : std::ldexp(1, -std::ilogb(distance));
    const Vec3 across{2 * p.half_x * unit, 0, 0}, down{0, 2 * p.half_y * unit, 0};
    const Vec3 first{(p.x - p.half_x) * unit, (p.y - p.half_y) * unit, unit},
        last{(p.x + p.half_x) * unit, (p.y + p.half_y) * unit, unit};
    sr += triangle_solid_angle(first, across, down) + triangle_solid_angle(last, -across, -down);
  });
  return sr;
}

Shares integrate(const Part& cell) {
  static const Nodes kThree = three_nodes(), kFive = five_nodes();
  Shares sum;
  for_each_part(cell, kCoarse, [&sum](const Part& p, double distance) {
    const bool is_fine = std::max(p.half_x, p.half_y) <= kFine * distance;
    for_each_node(p, is_fine ? kThree : kFive, [&sum](double w, double s, double t) {
      sum.w00 += w * (1 - s) * (1 - t);
      sum.w10 += w * s * (1 - t);
      sum.w01 += w * (1 - s) * t;
      sum.w11 += w * s * t;
    });
  });
  return sum;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const ProjectedPicture>> ProjectedPicture::create(
    const ProjectedPictureParams& params) {
  if (!(params.fov_rad > 0 && params.fov_rad < std::numbers::pi))
    return absl::InvalidArgumentError(
        fmt::format("projection.fov = {} rad, allowed (0, pi)", params.fov_rad));
  if (!(params.aspect > 0 && std::isfinite(params.aspect)))
    return absl::InvalidArgumentError(
        fmt::format("projection.aspect = {}, allowed: finite, positive", params.aspect));
  const double shorter = std::tan(params.fov_rad / 2);
  const Vec2 half = params.aspect >= 1 ? Vec2{shorter * params.aspect, shorter}
                                       : Vec2{shorter, shorter / params.aspect};
  // Outside of this range, squares underflow or overflow.
  constexpr double kLeast = 1e-140, kMost = 1e140;
  if (!(std::min(half.x, half.y) >= kLeast && std::max(half.x, half.y) <= kMost))
    return absl::InvalidArgumentError(fmt::format(
        "projection.fov = {} rad and aspect = {}, allowed: tangents of both half angles, which are "
        "{} and {}, from {} to {}",
        params.fov_rad, params.aspect, half.x, half.y, kLeast, kMost));
  ProjectedPictureParams used = params;
  std::shared_ptr<const Image> image = params.image;
  if (image == nullptr) {
    auto white = Image::create(1, 1, {Rgbf(1)});
    if (!white.ok()) return white.status();
    image = *std::move(white);
    used.filter = ImageFilter::kNearest;
  }
  return std::shared_ptr<const ProjectedPicture>(
      new ProjectedPicture(used, std::move(image), half));
}

ProjectedPicture::ProjectedPicture(const ProjectedPictureParams& params,
                                   std::shared_ptr<const Image> image, Vec2 half)
    : params_(params),
      image_(std::move(image)),
      half_(half),
      cells_(across(), down(), nearest() ? integrate_texels() : integrate_cells(),
             ImageFilter::kNearest, ImageBorder::kClamp) {
  sum_by_centres();
}

double ProjectedPicture::relative_error() const { return nearest() ? 0 : 1e-14; }

double ProjectedPicture::edge(int i, int n, double half) const {
  const double at = nearest() ? i : std::clamp(i - 0.5, 0.0, static_cast<double>(n));
  return half * ((2 * at - n) / n);
}

ProjectedPicture::Stretch ProjectedPicture::stretch(int i, int n, double half) const {
  const double begin = edge(i, n, half), end = edge(i + 1, n, half);
  const bool is_halved = !nearest() && (i == 0 || i == n);
  // Cells beside the middle must meet exactly: near 180 degrees, all light passes through 1e-16 of
  // a side.  Elsewhere a difference of edges would lose as many digits as the number of texels has.
  const bool is_away = std::min(std::fabs(begin), std::fabs(end)) > 8 * (end - begin);
  return {(begin + end) / 2, is_away ? half / n / (is_halved ? 2 : 1) : (end - begin) / 2};
}

Rgb ProjectedPicture::corner(int column, int row) const {
  return Rgb(image_->texel(std::clamp(column, 0, image_->width() - 1),
                           std::clamp(row, 0, image_->height() - 1)));
}

ProjectedPicture::Cell ProjectedPicture::cell(int column, int row) const {
  const int w = image_->width(), h = image_->height();
  const int first = nearest() ? 0 : -1, last = 0;
  const auto at = [&](int i, int j) { return luminance(corner(column + i, row + j)); };
  return {edge(column, w, half_.x),
          edge(column + 1, w, half_.x),
          edge(row, h, half_.y),
          edge(row + 1, h, half_.y),
          {at(first, first), at(last, first), at(first, last), at(last, last)}};
}

std::vector<double> ProjectedPicture::integrate_texels() {
  const int w = image_->width(), h = image_->height();
  std::vector<Stretch> columns;
  for (int x = 0; x < w; ++x) columns.push_back(stretch(x, w, half_.x));
  std::vector<double> weights;
  weights.reserve(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  StopPoll poll;
  for (int y = 0; y < h; ++y) {
    const Stretch along_y = stretch(y, h, half_.y);
    Rgb row;
    for (int x = 0; x < w; ++x, poll()) {
      const Rgb texel(image_->texel(x, y));
      const double sr =
          texel.is_black() ? 0 : solid_angle({columns[static_cast<std::size_t>(x)], along_y});
      row += texel * sr;
      weights.push_back(luminance(texel) * sr);
    }
    integral_ += row;
  }
  return weights;
}

std::vector<double> ProjectedPicture::integrate_cells() {
  std::vector<double> weights;
  weights.reserve(static_cast<std::size_t>(across()) * static_cast<std::size_t>(down()));
  StopPoll poll;
  for (int y = 0; y < down(); ++y) {
    const Stretch along_y = stretch(y, image_->height(), half_.y);
    Rgb row;
    for (int x = 0; x < across(); ++x, poll()) {
      const Shares shares = integrate({stretch(x, image_->width(), half_.x), along_y});
      const Rgb sum = corner(x - 1, y - 1) * shares.w00 + corner(x, y - 1) * shares.w10 +
                      corner(x - 1, y) * shares.w01 + corner(x, y) * shares.w11;
      row += sum;
      weights.push_back(luminance(sum));
    }
    integral_ += row;
  }
  return weights;
}

void ProjectedPicture::sum_by_centres() {
  const int w = image_->width(), h = image_->height();
  StopPoll poll;
  for (int y = 0; y < h; ++y) {
    Rgb row;
    for (int x = 0; x < w; ++x, poll()) {
      const Rgb texel(image_->texel(x, y));
      row +=
          texel * sr_per_area(half_.x * ((2 * x + 1.0) / w - 1), half_.y * ((2 * y + 1.0) / h - 1));
      brightest_ = {std::max(brightest_.r, texel.r), std::max(brightest_.g, texel.g),
                    std::max(brightest_.b, texel.b)};
    }
    integral_by_centres_ += row;
  }
  integral_by_centres_ = integral_by_centres_ * (2 * half_.x / w * (2 * half_.y / h));
}

std::optional<Vec2> ProjectedPicture::find(const Vec3& w) const {
  if (!(w.z > 0)) return std::nullopt;
  const double x = w.x / w.z / half_.x, y = w.y / w.z / half_.y;
  if (!(std::fabs(x) <= 1 && std::fabs(y) <= 1)) return std::nullopt;
  return Vec2{(1 + x) / 2, (1 - y) / 2};
}

Rgb ProjectedPicture::lookup(Vec2 p) const {
  return image_->lookup(p, params_.filter, ImageBorder::kClamp);
}

Vec3 ProjectedPicture::sample(Vec2 u) const {
  const Vec2 p = cells_.sample(u).position;
  const auto split = [](double at, int n) {
    const int i = std::clamp(static_cast<int>(at * n), 0, n - 1);
    return std::pair{i, at * n - i};
  };
  const auto [column, u_x] = split(p.x, across());
  const auto [row, u_y] = split(p.y, down());
  const Cell c = cell(column, row);
  Vec2 share = c.luminance.sample({u_x, u_y});
  if (const auto sr =
          SphericalRectangle::create({c.x0, c.y0, 1}, {c.x1 - c.x0, 0, 0}, {0, c.y1 - c.y0, 0}))
    share = sr->sample(share);
  const double x = c.x0 + (c.x1 - c.x0) * share.x, y = c.y0 + (c.y1 - c.y0) * share.y;
  return normalized(Vec3{x, -y, 1});
}

double ProjectedPicture::per_sr(const Vec3& w) const {
  const std::optional<Vec2> p = find(w);
  if (!p || empty()) return 0;
  const auto index = [&](double at, int n) {
    if (nearest()) return std::min(static_cast<int>(at * n), n - 1);
    return between_centres(at, n).first + 1;
  };
  const int column = index(p->x, image_->width()), row = index(p->y, image_->height());
  const Cell c = cell(column, row);
  const double chosen =
      cells_.pdf({(column + 0.5) / across(), (row + 0.5) / down()}) / across() / down();
  const double x = w.x / w.z, y = -w.y / w.z;
  const Vec2 share{std::clamp((x - c.x0) / (c.x1 - c.x0), 0.0, 1.0),
                   std::clamp((y - c.y0) / (c.y1 - c.y0), 0.0, 1.0)};
  if (!(chosen > 0)) return 0;
  if (const auto sr =
          SphericalRectangle::create({c.x0, c.y0, 1}, {c.x1 - c.x0, 0, 0}, {0, c.y1 - c.y0, 0}))
    return chosen * c.luminance.pdf(sr->invert(share)) / sr->solid_angle_sr();
  return chosen * c.luminance.pdf(share) / ((c.x1 - c.x0) * (c.y1 - c.y0)) / sr_per_area(x, y);
}

}  // namespace lucerna
