#include "lights/pictures/sphere_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

Vec2 equal_area_square(const Vec3& w) {
  // Computes 1 - |z| without cancellation near the poles.
  const double r = std::sqrt((w.x * w.x + w.y * w.y) / (1 + std::fabs(w.z)));
  const double share = std::atan2(std::fabs(w.y), std::fabs(w.x)) * (2 / kPi);
  double v = share * r;
  double u = r - v;
  if (w.z < 0) {
    // The lower half is folded outwards over the diagonals.
    std::swap(u, v);
    u = 1 - u;
    v = 1 - v;
  }
  return {std::clamp((std::copysign(u, w.x) + 1) / 2, 0.0, 1.0),
          std::clamp((std::copysign(v, w.y) + 1) / 2, 0.0, 1.0)};
}

Vec3 equal_area_direction(Vec2 p) {
  const double u = 2 * p.x - 1;
  const double v = 2 * p.y - 1;
  const double inside = 1 - (std::fabs(u) + std::fabs(v));
  const double r = 1 - std::fabs(inside);
  const double phi = r > 0 ? ((std::fabs(v) - std::fabs(u)) / r + 1) * (kPi / 4) : kPi / 4;
  const double rho = r * std::sqrt(2 - r * r);
  return {std::copysign(std::cos(phi), u) * rho, std::copysign(std::sin(phi), v) * rho,
          std::copysign(1 - r * r, inside)};
}

Vec2 latitude_longitude_square(const Vec3& w) {
  double turn = std::atan2(w.z, w.x) / (2 * kPi);
  if (turn < 0) turn = std::min(turn + 1, 1.0);
  return {turn, std::atan2(std::sqrt(w.x * w.x + w.z * w.z), w.y) / kPi};
}

Vec3 from_longitude(double turn, double sin_theta, double cos_theta) {
  const double phi = 2 * kPi * turn;
  return {sin_theta * std::cos(phi), cos_theta, sin_theta * std::sin(phi)};
}

/// cos(pi begin) - cos(pi end), without cancellation.
double height_between(double begin, double end) {
  return 2 * std::sin(kPi * (begin + end) / 2) * std::sin(kPi * (end - begin) / 2);
}

/// A row of cells of a latitude-longitude map.
struct Strip {
  double begin, end;  ///< of the square
  double height;      ///< in the cosine of the polar angle
  /// Factor from a density by area of the square, with straightened strips, to one by solid angle.
  double sr_from_square() const { return 1 / (2 * kPi * height / (end - begin)); }
};

/// Texels for the nearest filter, and what lies between centres for the bilinear filter.
int strips_of(ImageFilter filter, int texels) {
  return texels + (filter == ImageFilter::kNearest ? 0 : 1);
}

Strip strip_of(ImageFilter filter, int texels, int row) {
  const double n = texels;
  const double half = filter == ImageFilter::kNearest ? 0 : 0.5;
  const double begin = std::max(0.0, (row - half) / n);
  const double end = std::min(1.0, (row + 1 - half) / n);
  return {begin, end, height_between(begin, end)};
}

/// sin d - d cos d, by its series where the difference cancels.
double sin_less_d_cos(double d) {
  if (d > 0.02) return std::sin(d) - d * std::cos(d);
  const double d2 = d * d;
  return d * d2 * (1.0 / 3 - d2 * (1.0 / 30 - d2 / 840));
}

/// The integral over the sphere of a latitude-longitude picture.  The weight of each row of texels
/// is the integral of its filter over latitudes.
Rgb integrate_rows(const Image& image, ImageFilter filter) {
  const int height = image.height();
  std::vector<double> measures(static_cast<std::size_t>(height));
  if (filter == ImageFilter::kNearest) {
    StopPoll poll;
    for (int y = 0; y < height; ++y, poll())
      measures[static_cast<std::size_t>(y)] = strip_of(filter, height, y).height;
  } else {
    // Between the centres of two rows, the share is linear in the polar angle theta = m + t.  At
    // the poles both are the same row.  It is turned there, which does not change its sum.
    for (int strip = 0; strip <= height; ++strip) {
      const auto [begin, end, measure] = strip_of(filter, height, strip);
      const double m = kPi * (begin + end) / 2;
      const double d = kPi * (end - begin) / 2;
      const double constant = 2 * std::sin(m) * std::sin(d);
      const double linear = 2 * std::cos(m) * sin_less_d_cos(d);
      const double share = (begin + end) / 2 * height + 0.5 - strip;
      const double below = share * constant + height / kPi * linear;
      measures[static_cast<std::size_t>(std::min(strip, height - 1))] += below;
      measures[static_cast<std::size_t>(std::max(strip - 1, 0))] += constant - below;
    }
  }
  Rgb sum;
  StopPoll poll;
  for (int y = 0; y < height; ++y) {
    Rgb row;
    for (int x = 0; x < image.width(); ++x, poll()) row += Rgb(image.texel(x, y));
    sum += row * measures[static_cast<std::size_t>(y)];
  }
  return sum * (2 * kPi / image.width());
}

}  // namespace

Vec2 square_from_direction(SphereMapping mapping, const Vec3& w) {
  return mapping == SphereMapping::kEqualArea ? equal_area_square(w) : latitude_longitude_square(w);
}

Vec3 direction_from_square(SphereMapping mapping, Vec2 p) {
  if (mapping == SphereMapping::kEqualArea) return equal_area_direction(p);
  return from_longitude(p.x, std::sin(kPi * p.y), std::cos(kPi * p.y));
}

absl::StatusOr<std::shared_ptr<const SphereMap>> SphereMap::create(
    std::shared_ptr<const Image> image, SphereMapping mapping, ImageFilter filter) {
  if (image == nullptr) return absl::InvalidArgumentError("a sphere map without an image");
  if (mapping == SphereMapping::kEqualArea && image->width() != image->height())
    return absl::InvalidArgumentError(
        fmt::format("an equal-area map of {} x {} texels, allowed: square (others can be "
                    "latitude-longitude maps)",
                    image->width(), image->height()));
  return std::shared_ptr<const SphereMap>(new SphereMap(std::move(image), mapping, filter));
}

namespace {

/// The range of cosines between the mapping's axis and the directions of a rectangle.  The axis is
/// +z of an equal-area map, else +y.  The rectangle may extend beyond the square.
std::pair<double, double> cosines_of(SphereMapping mapping, Vec2 from, Vec2 to) {
  if (mapping == SphereMapping::kLatitudeLongitude)
    return {std::cos(kPi * std::min(1.0, to.y)), std::cos(kPi * std::max(0.0, from.y))};
  // The cosine falls with r = |u| + |v|, from 1 in the middle to -1 in the corners.
  const auto least = [](double a, double b) {
    return a * b < 0 ? 0 : std::min(std::fabs(a), std::fabs(b));
  };
  const auto most = [](double a, double b) { return std::max(std::fabs(a), std::fabs(b)); };
  const auto cosine = [](double r) {
    return r < 1 ? 1 - r * r : (2 - std::min(r, 2.0)) * (2 - std::min(r, 2.0)) - 1;
  };
  const Vec2 a{2 * from.x - 1, 2 * from.y - 1}, b{2 * to.x - 1, 2 * to.y - 1};
  return {cosine(most(a.x, b.x) + most(a.y, b.y)), cosine(least(a.x, b.x) + least(a.y, b.y))};
}

}  // namespace

SphereMap::SphereMap(std::shared_ptr<const Image> image, SphereMapping mapping, ImageFilter filter)
    : image_(std::move(image)),
      mapping_(mapping),
      filter_(filter),
      integral_(mapping == SphereMapping::kEqualArea ? image_->mean() * (4 * kPi)
                                                     : integrate_rows(*image_, filter)) {
  const double h = image_->height(), w = image_->width();
  // The bilinear filter extends a texel by half a texel on each side.
  const double spread = filter == ImageFilter::kNearest ? 0 : 0.5;
  StopPoll poll;
  for (int y = 0; y < image_->height(); ++y)
    for (int x = 0; x < image_->width(); ++x, poll()) {
      if (Rgb(image_->texel(x, y)).is_black()) continue;
      const auto [low, high] = cosines_of(mapping, {(x - spread) / w, (y - spread) / h},
                                          {(x + 1 + spread) / w, (y + 1 + spread) / h});
      low_ = std::min(low_, low), high_ = std::max(high_, high);
      if (mapping == SphereMapping::kLatitudeLongitude) break;  // the same for the whole row
    }
}

ImageBorder SphereMap::border() const {
  return mapping_ == SphereMapping::kEqualArea ? ImageBorder::kOctahedral
                                               : ImageBorder::kLatitudeLongitude;
}

Rgb SphereMap::lookup(const Vec3& w) const { return lookup(square_from_direction(mapping_, w)); }

double SphereMap::lit_height(const Vec3& n) const {
  if (low_ > high_) return 0;
  const bool equal_area = mapping_ == SphereMapping::kEqualArea;
  const double along = equal_area ? n.z : n.y;
  const double across = std::hypot(n.x, equal_area ? n.y : n.z);
  // Of the directions with cosine c, the nearest to `n` has the height
  // along c + across sqrt(1 - c^2).
  const double c = std::clamp(along, low_, high_);
  const double height = along * c + across * std::sqrt(std::max(0.0, 1 - c * c));
  return height > 1e-12 ? std::min(1.0, height) : 0;
}

MapAxes::MapAxes(const Transform& world_from_map)
    : x_(normalized(world_from_map.vector({1, 0, 0}))),
      y_(normalized(world_from_map.vector({0, 1, 0}))) {
  // Exactly at right angles, and mirrored if the transform is.
  y_ = normalized(y_ - x_ * dot(x_, y_));
  z_ = cross(x_, y_);
  if (world_from_map.swaps_handedness()) z_ = -z_;
}

namespace {

ImageDistribution distribution_of(const SphereMap& map, double subtract) {
  const Image& image = map.image();
  std::vector<double> measures;
  if (map.mapping() == SphereMapping::kLatitudeLongitude)
    for (int row = 0; row < strips_of(map.filter(), image.height()); ++row)
      measures.push_back(strip_of(map.filter(), image.height(), row).height / 2);
  return {image.width(), image.height(), luminances(image, subtract),
          map.filter(),  map.border(),   std::move(measures)};
}

}  // namespace

SphereDistribution::SphereDistribution(const SphereMap& map, double subtract)
    : mapping_(map.mapping()),
      filter_(map.filter()),
      height_(map.image().height()),
      squares_(distribution_of(map, subtract)) {}

int SphereDistribution::row_of(double y) const {
  if (filter_ == ImageFilter::kNearest)
    return std::clamp(static_cast<int>(y * height_), 0, height_ - 1);
  return between_centres(y, height_).first + 1;
}

SphereDistribution::Sample SphereDistribution::sample(Vec2 u) const {
  const ImageDistribution::Sample s = squares_.sample(u);
  if (mapping_ == SphereMapping::kEqualArea)
    return {equal_area_direction(s.position), s.position, s.pdf / (4 * kPi)};
  const Strip row = strip_of(filter_, height_, row_of(s.position.y));
  const double share = std::clamp((s.position.y - row.begin) / (row.end - row.begin), 0.0, 1.0);
  // Half angles from the nearer pole, so that nothing cancels at either pole.
  const double sin_begin = std::sin(kPi * row.begin / 2);
  const double cos_end = std::cos(kPi * row.end / 2);
  const double sin2 = sin_begin * sin_begin + share * row.height / 2;
  const double cos2 = cos_end * cos_end + (1 - share) * row.height / 2;
  const double theta = 2 * std::atan2(std::sqrt(sin2), std::sqrt(cos2));
  // Keep rounding from moving it into the next row.
  const double inside = (row.end - row.begin) * 0x1p-32;
  const double y = std::clamp(theta / kPi, row.begin + inside, row.end - inside);
  return {from_longitude(s.position.x, 2 * std::sqrt(sin2 * cos2), cos2 - sin2),
          {s.position.x, y},
          s.pdf * row.sr_from_square()};
}

double SphereDistribution::per_sr(const Vec3& w) const {
  Vec2 p = square_from_direction(mapping_, w);
  if (mapping_ == SphereMapping::kEqualArea) return squares_.pdf(p) / (4 * kPi);
  const Strip row = strip_of(filter_, height_, row_of(p.y));
  const double share = std::clamp(height_between(row.begin, p.y) / row.height, 0.0, 1.0);
  if (filter_ == ImageFilter::kBilinear) p.y = row.begin * (1 - share) + row.end * share;
  return squares_.pdf(p) * row.sr_from_square();
}

}  // namespace lucerna
