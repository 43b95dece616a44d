#include "server/materials/image_lookup.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace lucerna {
namespace {

/// 0 to n - 1 for a texel that lies outside, or nothing.
std::optional<int> wrapped(int i, int n, TextureWrap wrap) {
  if (i >= 0 && i < n) return i;
  switch (wrap) {
    case TextureWrap::kBlack:
      return std::nullopt;
    case TextureWrap::kRepeat:
      return ((i % n) + n) % n;
    case TextureWrap::kMirror: {
      const int j = ((i % (2 * n)) + 2 * n) % (2 * n);
      return j < n ? j : 2 * n - 1 - j;
    }
    default:
      return std::clamp(i, 0, n - 1);
  }
}

/// Texel coordinates far outside of the picture: their fraction is lost, and int cannot hold them.
constexpr double kMostTexels = 1 << 30;

double texel_coordinate(double x, int n, TextureWrap wrap) {
  if (wrap == TextureWrap::kRepeat) x -= std::floor(x);
  if (wrap == TextureWrap::kMirror) x -= 2 * std::floor(x / 2);
  return std::clamp(x * n, -kMostTexels, kMostTexels);
}

/// One of the copies of a picture.
class Level {
 public:
  Level(const ImageTexture& texture, std::size_t number)
      : t_(texture), image_(texture.image->level(number)) {}

  int width() const { return image_.width(); }
  int height() const { return image_.height(); }
  /// Texel coordinates, y downwards.
  Vec2 position(const Vec2& st) const {
    return {texel_coordinate(st.x, width(), t_.wrap_s),
            texel_coordinate(1 - st.y, height(), t_.wrap_t)};
  }
  Rgb texel(int x, int y) const {
    if (t_.wrap_s == TextureWrap::kOctahedral) {
      const auto [ix, iy] = at_border(ImageBorder::kOctahedral, std::clamp(x, -1, width()),
                                      std::clamp(y, -1, height()), width(), height());
      return image_.texel(ix, iy);
    }
    const auto i = wrapped(x, width(), t_.wrap_s), j = wrapped(y, height(), t_.wrap_t);
    return i && j ? image_.texel(*i, *j) : Rgb{};
  }
  Rgb nearest(const Vec2& st) const {
    const Vec2 p = position(st);
    return texel(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)));
  }
  Rgb bilinear(const Vec2& st) const {
    const Vec2 p = position(st);
    const double left = std::floor(p.x - 0.5), top = std::floor(p.y - 0.5);
    const double u = p.x - 0.5 - left, v = p.y - 0.5 - top;
    const int i = static_cast<int>(left), j = static_cast<int>(top);
    return (texel(i, j) * (1 - u) + texel(i + 1, j) * u) * (1 - v) +
           (texel(i, j + 1) * (1 - u) + texel(i + 1, j + 1) * u) * v;
  }
  /// A Gaussian over the ellipse whose half axes follow from `steps`, and over at least one texel.
  /// [Heckbert89, 3.5.8]
  Rgb gaussian(const Vec2& st, const CoordinateSteps& steps) const {
    const Vec2 p = position(st);
    const double w = width(), h = height();
    const double ax = steps.x.x * w, ay = -steps.x.y * h, bx = steps.y.x * w, by = -steps.y.y * h;
    // The ellipse is e x^2 + f x y + g y^2 = e g - f^2 / 4.
    const double e = ay * ay + by * by + 1, f = -2 * (ax * ay + bx * by), g = ax * ax + bx * bx + 1,
                 most = e * g - f * f / 4;
    const double half_width = std::sqrt(g), half_height = std::sqrt(e);
    const double cx = p.x - 0.5, cy = p.y - 0.5;
    const auto texel_at = [](double x) {
      return static_cast<int>(std::clamp(x, -kMostTexels, kMostTexels));
    };
    const int x0 = texel_at(std::ceil(cx - half_width)), x1 = texel_at(std::floor(cx + half_width));
    const int y0 = texel_at(std::ceil(cy - half_height)),
              y1 = texel_at(std::floor(cy + half_height));
    Rgb sum;
    double weights = 0;
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const double dx = x - cx, dy = y - cy;
        const double r2 = (e * dx * dx + f * dx * dy + g * dy * dy) / most;
        if (!(r2 < 1)) continue;
        // Falls to 0 at the edge of the ellipse.
        constexpr double kAlpha = 2;
        const double weight = std::exp(-kAlpha * r2) - std::exp(-kAlpha);
        sum += texel(x, y) * weight;
        weights += weight;
      }
    return weights > 0 ? sum / weights : bilinear(st);
  }

 private:
  const ImageTexture& t_;
  const Texels& image_;
};

/// `of(level)` between two copies of the picture.  `number` 0: the picture.
template <typename Of>
Rgb between_levels(const ImageTexture& t, double number, const Of& of) {
  const std::size_t last = t.image->levels() - 1;
  if (!(number < static_cast<double>(last))) return Level(t, last).texel(0, 0);
  if (!(number > 0)) return of(Level(t, 0));
  const auto below = static_cast<std::size_t>(number);
  const double share = number - static_cast<double>(below);
  return of(Level(t, below)) * (1 - share) + of(Level(t, below + 1)) * share;
}

/// The copy of the picture whose texels are as wide as `width` of the picture.
double level_of(const ImageTexture& t, double width) {
  return std::log2(width * std::max(t.image->width(), t.image->height()));
}

Rgb trilinear(const ImageTexture& t, const Vec2& st, const CoordinateSteps& d) {
  const double width =
      2 * std::max({std::fabs(d.x.x), std::fabs(d.x.y), std::fabs(d.y.x), std::fabs(d.y.y)});
  return between_levels(t, level_of(t, width), [&](const Level& l) { return l.bilinear(st); });
}

Rgb elliptical(const ImageTexture& t, const Vec2& st, CoordinateSteps d) {
  double longer = std::hypot(d.x.x, d.x.y), shorter = std::hypot(d.y.x, d.y.y);
  if (longer < shorter) std::swap(longer, shorter), std::swap(d.x, d.y);
  // A long ellipse is made wider, so that it has few texels.
  if (shorter * t.most_anisotropy < longer && shorter > 0) {
    const double wider = longer / (shorter * t.most_anisotropy);
    d.y = {d.y.x * wider, d.y.y * wider};
    shorter *= wider;
  }
  if (!(shorter > 0)) return Level(t, 0).bilinear(st);
  return between_levels(t, level_of(t, shorter), [&](const Level& l) { return l.gaussian(st, d); });
}

bool is_finite(const Vec2& v) { return std::isfinite(v.x) && std::isfinite(v.y); }

}  // namespace

Rgb look_up(const ImageTexture& texture, const Vec2& st, const CoordinateSteps* steps) {
  if (!is_finite(st)) return {};
  if (texture.filter == TextureFilter::kNearest) return Level(texture, 0).nearest(st);
  if (!uses_levels(texture.filter) || steps == nullptr || !is_finite(steps->x) ||
      !is_finite(steps->y))
    return Level(texture, 0).bilinear(st);
  return texture.filter == TextureFilter::kTrilinear ? trilinear(texture, st, *steps)
                                                     : elliptical(texture, st, *steps);
}

}  // namespace lucerna
