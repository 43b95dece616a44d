#include "lights/pictures/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lights/maths/stop_poll.h"

namespace lucerna {

BetweenCentres between_centres(double coordinate, int n) {
  const double at = std::clamp(coordinate, 0.0, 1.0) * n - 0.5;
  const int first = std::min(static_cast<int>(std::floor(at)), n - 1);
  return {first, at - first};
}

TexelIndex at_border(ImageBorder border, int x, int y, int width, int height) {
  if (border == ImageBorder::kLatitudeLongitude) {
    if (y < 0 || y >= height) {
      y = y < 0 ? 0 : height - 1;
      x += width / 2;
    }
    return {(x + width) % width, y};
  }
  if (border == ImageBorder::kOctahedral) {
    // Each edge is folded at its middle, so its two halves meet.
    if (x < 0 || x >= width) {
      x = x < 0 ? 0 : width - 1;
      y = height - 1 - y;
    }
    if (y < 0 || y >= height) {
      y = y < 0 ? 0 : height - 1;
      x = width - 1 - x;
    }
    return {x, y};
  }
  return {std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1)};
}

absl::StatusOr<std::shared_ptr<const Image>> Image::create(int width, int height,
                                                           std::vector<Rgbf> texels) {
  if (width < 1 || height < 1)
    return absl::InvalidArgumentError(
        fmt::format("an image of {} x {} texels, allowed: at least 1 x 1", width, height));
  if (texels.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return absl::InvalidArgumentError(
        fmt::format("{} texels for an image of {} x {}", texels.size(), width, height));
  StopPoll poll;
  for (std::size_t i = 0; i < texels.size(); ++i, poll()) {
    const Rgbf& t = texels[i];
    if (is_finite(t) && t.r >= 0 && t.g >= 0 && t.b >= 0) continue;
    return absl::InvalidArgumentError(fmt::format(
        "texel ({}, {}), columns and rows from 0 at the upper left, is ({}, {}, {}), allowed: "
        "finite, not negative",
        i % static_cast<std::size_t>(width), i / static_cast<std::size_t>(width), t.r, t.g, t.b));
  }
  return std::shared_ptr<const Image>(new Image(width, height, std::move(texels)));
}

Image::Image(int width, int height, std::vector<Rgbf> texels)
    : width_(width), height_(height), texels_(std::move(texels)) {}

Rgb Image::lookup(Vec2 p, ImageFilter filter, ImageBorder border) const {
  if (filter == ImageFilter::kNearest) {
    const auto index = [](double c, int n) {
      return std::min(static_cast<int>(std::clamp(c, 0.0, 1.0) * n), n - 1);
    };
    return Rgb(texel(index(p.x, width_), index(p.y, height_)));
  }
  const BetweenCentres x = between_centres(p.x, width_);
  const BetweenCentres y = between_centres(p.y, height_);
  const auto corner = [&](int i, int j) {
    const TexelIndex t = at_border(border, x.first + i, y.first + j, width_, height_);
    return Rgb(texel(t.x, t.y));
  };
  const auto row = [&](int j) { return corner(0, j) * (1 - x.share) + corner(1, j) * x.share; };
  return row(0) * (1 - y.share) + row(1) * y.share;
}

Rgb Image::mean() const {
  // Row by row, so that rounding grows with the side and not with the area.
  Rgb sum;
  StopPoll poll;
  for (int y = 0; y < height_; ++y) {
    Rgb row;
    for (int x = 0; x < width_; ++x, poll()) row += Rgb(texel(x, y));
    sum += row;
  }
  return sum / (static_cast<double>(width_) * height_);
}

Rgb Image::brightest() const {
  Rgb most;
  StopPoll poll;
  for (const Rgbf& texel : texels_) {
    poll();
    const Rgb t(texel);
    most = {std::max(most.r, t.r), std::max(most.g, t.g), std::max(most.b, t.b)};
  }
  return most;
}

}  // namespace lucerna
