#include "lights/pictures/intensity_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "lights/maths/normal_cone.h"
#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

/// The image with the mean of each texel's channels in all channels.  The same image if it is grey
/// already.
std::shared_ptr<const Image> grey(std::shared_ptr<const Image> image) {
  if (is_grey(*image)) return image;
  std::vector<Rgbf> texels;
  texels.reserve(image->texels().size());
  StopPoll poll;
  for (const Rgbf& texel : image->texels()) {
    poll();
    const Rgb t(texel);
    texels.emplace_back(static_cast<float>((t.r + t.g + t.b) / 3));
  }
  // Means of valid texels are valid.
  return *Image::create(image->width(), image->height(), std::move(texels));
}

/// A bound on the angle between the centre of a texel and the directions that it lights [rad]. A
/// texel reaches half a texel to each side with the nearest filter, a whole texel with the bilinear
/// filter.
double reach(const SphereMap& map) {
  const double texels = map.filter() == ImageFilter::kNearest ? 0.5 : 1;
  if (map.mapping() == SphereMapping::kLatitudeLongitude)
    return std::hypot(kPi * texels / map.image().height(), 2 * kPi * texels / map.image().width());
  // Steps du, dv <= h in [-1, 1]^2 change r = |u| + |v| by dr <= 2 h, and the azimuth's share of
  // its quadrant by ds <= 2 h / r.  Here sin(theta / 2) = r / sqrt(2).  Along a meridian, the
  // direction turns by 2 / sqrt(2 - r^2) dr <= 2 dr.  Across, it turns by sin(theta) pi / 4 ds = r
  // sqrt(2 - r^2) pi / 4 ds.  The map is continuous over folds and edges.
  const double h = 2 * texels / map.image().width();
  return h * std::hypot(4, kPi / std::numbers::sqrt2);
}

}  // namespace

bool is_grey(const Image& image) {
  StopPoll poll;
  return std::ranges::all_of(image.texels(), [&](const Rgbf& t) {
    poll();
    return t.r == t.g && t.g == t.b;
  });
}

absl::StatusOr<std::shared_ptr<const IntensityMap>> IntensityMap::create(
    std::shared_ptr<const Image> image, SphereMapping mapping, ImageFilter filter) {
  if (image != nullptr) image = grey(std::move(image));
  auto map = SphereMap::create(std::move(image), mapping, filter);
  if (!map.ok()) return map.status();
  return std::shared_ptr<const IntensityMap>(new IntensityMap(*std::move(map)));
}

IntensityMap::IntensityMap(std::shared_ptr<const SphereMap> map)
    : map_(std::move(map)), distribution_(*map_) {
  bound();
}

void IntensityMap::bound() {
  const Image& image = map_->image();
  const auto for_each_lit = [&](auto&& f) {
    StopPoll poll;
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x, poll())
        if (const double cd = image.texel(x, y).r; cd > 0)
          f(cd, direction_from_square(map_->mapping(),
                                      {(x + 0.5) / image.width(), (y + 0.5) / image.height()}));
  };
  // Any axis gives a valid cone, so the rows of a latitude-longitude map need no weights.
  Vec3 mean;
  for_each_lit([&](double cd, const Vec3& w) {
    max_cd_ = std::max(max_cd_, cd);
    mean += w * cd;
  });
  if (const Vec3 axis = normalized(mean); is_finite(axis) && axis != Vec3{}) cone_.axis = axis;
  for_each_lit([&](double, const Vec3& w) {
    cone_.half_angle_rad = std::max(cone_.half_angle_rad, angle_between(cone_.axis, w));
  });
  // The angle by which rounding to float may turn a direction.
  constexpr double kSlack = 1e-6;
  cone_.half_angle_rad = std::min(kPi, cone_.half_angle_rad + reach(*map_) + kSlack);
}

double IntensityMap::at(const Vec3& w) const { return map_->lookup(normalized(w)).r; }

SolidAnglePdf IntensityMap::pdf(const Vec3& w) const {
  return {distribution_.per_sr(normalized(w))};
}

}  // namespace lucerna
