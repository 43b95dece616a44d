#include "lights/shapes/round_shape.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "lights/maths/stop_poll.h"

namespace lucerna {

PaintedArea RoundShape::painted_area(const Picture& picture) const {
  return {mean_over_rows(picture, [this](const Band& band) { return area_of(band); }) * area(), 0};
}

std::optional<ImageDistribution> RoundShape::distribution(const Picture& picture) const {
  const Image& image = *picture.image;
  std::vector<double> weights, measures;
  weights.reserve(static_cast<std::size_t>(image.width()) *
                  static_cast<std::size_t>(image.height()));
  StopPoll poll;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x, poll())
      weights.push_back(luminance(Rgb(image.texel(x, y))));
  for (const Band& row : rows_of_cells(picture)) measures.push_back(area_of(row).share);
  return if_not_black({image.width(), image.height(), std::move(weights), picture.filter,
                       ImageBorder::kClamp, std::move(measures)});
}

SurfacePoint RoundShape::sample_picture(const Picture& picture,
                                        const ImageDistribution& distribution, Vec2 u) const {
  const Vec2 at = distribution.sample(u).position;
  // Within a row of cells, points are chosen by area.  The part above the point is its share of
  // the row.
  const Band row = row_of_cells(picture, at.y);
  const double share = std::clamp((at.y - row.above) / row.height, 0.0, 1.0);
  const double above = area_of({0, row.above, 1 - row.above}).share + share * area_of(row).share;
  return at_shares({at.x, std::clamp(1 - above, 0.0, 1.0)});
}

AreaPdf RoundShape::pdf_picture(const Picture& picture, const ImageDistribution& distribution,
                                const SurfacePoint& point) const {
  const Vec2 at = uv(point);
  const double y = 1 - at.y;
  const Band row = row_of_cells(picture, y);
  const double measure = area_of(row).share;
  const double within = std::max(0.0, y - row.above);
  // Stay off the edges, which belong to the neighbours.
  const double share =
      std::clamp(area_of({row.above, within, 1 - y}).share / measure, 0x1p-30, 1 - 0x1p-30);
  const double of_square = distribution.pdf({at.x, row.above + row.height * share});
  return {of_square * row.height / measure / area()};
}

}  // namespace lucerna
