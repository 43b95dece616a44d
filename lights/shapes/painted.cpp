#include "lights/shapes/painted.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <type_traits>

#include "lights/maths/stop_poll.h"
#include "lights/shapes/shape.h"

namespace lucerna {
namespace {

template <typename Surface>
constexpr bool kHasRows = requires(const Surface& s, const Band& band) {
  s.area_of(band);
};

template <typename Surface>
struct MeshOf : std::false_type {
  static constexpr bool kTriangles = false, kPatches = false;
};
template <typename Primitive>
struct MeshOf<Mesh<Primitive>> : std::true_type {
  static constexpr bool kTriangles = std::is_same_v<Primitive, Triangle>;
  static constexpr bool kPatches = !kTriangles;
};

/// The share of the area above the coordinate y of the picture.
template <typename Surface>
double area_above(const Surface& surface, double y) {
  return surface.area_of({0, y, 1 - y}).share;
}

/// Interpolates the (u, v) of a triangle's corners at a point of it.
Vec2 interpolate(const Triangle& t, const Vec3& p, const Vec2f* uv) {
  const Vec2 shares = t.shares_at(p);
  const double s = std::clamp(shares.x, 0.0, 1.0), r = std::clamp(shares.y, 0.0, 1.0);
  const auto mix = [&](double x0, double x1, double x2) {
    return x0 + s * (x1 - x0) + r * (x2 - x0);
  };
  return {mix(uv[0].x, uv[1].x, uv[2].x), mix(uv[0].y, uv[1].y, uv[2].y)};
}

/// Whether `uv` is a corner of the picture.
template <typename T>
bool is_corner(const BasicVec2<T>& uv) {
  return (uv.x == 0 || uv.x == 1) && (uv.y == 0 || uv.y == 1);
}

}  // namespace

template <typename Surface>
Painted<Surface>::Painted(Data data) {
  const auto whole = std::make_shared<Data>(std::move(data));
  data_ = whole;
  whole->painted_area = measure();
  whole->distribution = distribution();
}

template <typename Surface>
absl::StatusOr<Painted<Surface>> Painted<Surface>::create(Surface surface, Picture picture,
                                                          std::vector<Vec2f> corner_uv) {
  std::size_t corners = 0;
  if constexpr (MeshOf<Surface>::value)
    corners = surface.size() * (MeshOf<Surface>::kTriangles ? 3 : 4);
  const bool optional = !MeshOf<Surface>::kTriangles;
  if (corner_uv.size() != corners && !(optional && corner_uv.empty()))
    return absl::InvalidArgumentError(
        fmt::format("painted.corner_uv has {} entries, allowed: one for each of {} corners",
                    corner_uv.size(), corners));
  StopPoll poll;
  for (std::size_t i = 0; i < corner_uv.size(); ++i, poll())
    if (!std::isfinite(corner_uv[i].x) || !std::isfinite(corner_uv[i].y))
      return absl::InvalidArgumentError(
          fmt::format("painted.corner_uv[{}] = ({}, {}), allowed: "
                      "finite",
                      i, corner_uv[i].x, corner_uv[i].y));
  return Painted(Data{std::move(surface), std::move(picture), std::move(corner_uv), {}, {}});
}

template <typename Surface>
Vec2 Painted<Surface>::corner(std::size_t patch, std::size_t corner) const {
  if (data_->corner_uv.empty()) return {double(corner & 1), double(corner >> 1)};
  const Vec2f& uv = data_->corner_uv[4 * patch + corner];
  return {uv.x, uv.y};
}

template <typename Surface>
bool Painted<Surface>::is_corner_to_corner(std::size_t patch) const {
  // Tests that the corners are those of the square in one of its eight symmetries.  The edges from
  // the first corner are then the axes.
  const Vec2 a = corner(patch, 0), b = corner(patch, 1), c = corner(patch, 2), d = corner(patch, 3);
  return is_corner(a) && is_corner(b) && is_corner(c) && is_corner(d) && b.x + c.x == a.x + d.x &&
         b.y + c.y == a.y + d.y && std::fabs(b.x - a.x) + std::fabs(b.y - a.y) == 1 &&
         std::fabs(c.x - a.x) + std::fabs(c.y - a.y) == 1 &&
         (b.x - a.x) * (c.x - a.x) + (b.y - a.y) * (c.y - a.y) == 0;
}

template <typename Surface>
std::optional<Vec2> Painted<Surface>::missing_in_first() const {
  if (data_->corner_uv.size() != 6) return std::nullopt;
  if constexpr (MeshOf<Surface>::kTriangles)
    if (!(data_->surface.share(0) > 0 && data_->surface.share(1) > 0)) return std::nullopt;
  // The fourth corner of the square, which completes the parallelogram of the three others.
  const auto missing = [&](const Vec2f* uv) -> std::optional<Vec2> {
    double x = 0, y = 0;
    for (int k = 0; k < 3; ++k) {
      if (!is_corner(uv[k]) || uv[k] == uv[(k + 1) % 3]) return std::nullopt;
      x += uv[k].x, y += uv[k].y;
    }
    return Vec2{2 - x, 2 - y};
  };
  const auto first = missing(&data_->corner_uv[0]), second = missing(&data_->corner_uv[3]);
  if (!first || !second || first->x + second->x != 1 || first->y + second->y != 1)
    return std::nullopt;
  return first;
}

template <typename Surface>
Vec2 Painted<Surface>::on_patch(std::size_t patch, Vec2 uv) const {
  const Vec2 a = corner(patch, 0), b = corner(patch, 1), c = corner(patch, 2);
  return {(uv.x - a.x) * (b.x - a.x) + (uv.y - a.y) * (b.y - a.y),
          (uv.x - a.x) * (c.x - a.x) + (uv.y - a.y) * (c.y - a.y)};
}

template <typename Surface>
Vec2 Painted<Surface>::uv(const SurfacePoint& point) const {
  if constexpr (kHasRows<Surface>) {
    return data_->surface.uv(point.position);
  } else {
    const std::size_t i = point.primitive < data_->surface.size() ? point.primitive : 0;
    const auto& primitive = data_->surface.primitive(i);
    if constexpr (MeshOf<Surface>::kTriangles) {
      return interpolate(primitive, point.position, &data_->corner_uv[3 * i]);
    } else {
      const Vec2 st = primitive.locate(point.position);
      if (data_->corner_uv.empty()) return {double{st.x}, double{st.y}};
      const auto mix = [&](auto&& coordinate) {
        return std::lerp(
            std::lerp(coordinate(corner(i, 0)), coordinate(corner(i, 1)), double{st.x}),
            std::lerp(coordinate(corner(i, 2)), coordinate(corner(i, 3)), double{st.x}),
            double{st.y});
      };
      return {mix([](const Vec2& p) { return p.x; }), mix([](const Vec2& p) { return p.y; })};
    }
  }
}

template <typename Surface>
PaintedArea Painted<Surface>::measure() const {
  PaintedArea whole;
  if constexpr (kHasRows<Surface>) {
    const auto area_of = [this](const Band& band) { return data_->surface.area_of(band); };
    whole = {mean_over_rows(data_->picture, area_of) * this->area(), 0};
  } else if constexpr (MeshOf<Surface>::kTriangles) {
    // Many primitives of a mesh have the same (u, v); without corner_uv, all have.
    std::map<std::array<float, 6>, Rgb> known;
    StopPoll poll;
    for (std::size_t i = 0; i < data_->surface.size(); ++i, poll()) {
      const Vec2f* uv = &data_->corner_uv[3 * i];
      const auto [entry, is_new] =
          known.try_emplace({uv[0].x, uv[0].y, uv[1].x, uv[1].y, uv[2].x, uv[2].y});
      if (is_new)
        entry->second = mean_over_triangle(
            data_->picture,
            {Vec2{uv[0].x, uv[0].y}, Vec2{uv[1].x, uv[1].y}, Vec2{uv[2].x, uv[2].y}});
      whole.m2 += entry->second * (data_->surface.share(i) * this->area());
    }
  } else {
    std::optional<PictureMoments> moments;
    StopPoll poll;
    for (std::size_t i = 0; i < data_->surface.size(); ++i, poll()) {
      const auto& patch = data_->surface.primitive(i);
      std::optional<PaintedArea> part;
      if (is_corner_to_corner(i) && patch.is_unfolded()) {
        if (!moments) moments.emplace(data_->picture);
        part = moments->times([&](Vec2 uv) { return patch.area_element(on_patch(i, uv)); },
                              patch.least_area_element());
      }
      if (!part) {
        const Vec2 a = corner(i, 0), b = corner(i, 1), c = corner(i, 2), d = corner(i, 3);
        part = sum_over_points(
            data_->picture,
            [&](Vec2 st) {
              const auto mix = [&](double a, double b, double c, double d) {
                return std::lerp(std::lerp(a, b, st.x), std::lerp(c, d, st.x), st.y);
              };
              return Vec2{mix(a.x, b.x, c.x, d.x), mix(a.y, b.y, c.y, d.y)};
            },
            [&](Vec2 st) { return patch.area_element(st); });
      }
      whole.m2 += part->m2;
      whole.error_m2 += part->error_m2;
    }
  }
  return whole;
}

template <typename Surface>
std::optional<ImageDistribution> Painted<Surface>::distribution() const {
  std::optional<ImageDistribution> made;
  const Image& image = *data_->picture.image;
  if constexpr (kHasRows<Surface>) {
    std::vector<double> weights, measures;
    weights.reserve(static_cast<std::size_t>(image.width()) *
                    static_cast<std::size_t>(image.height()));
    StopPoll poll;
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x, poll())
        weights.push_back(luminance(Rgb(image.texel(x, y))));
    for (const Band& row : rows_of_cells(data_->picture))
      measures.push_back(data_->surface.area_of(row).share);
    made.emplace(image.width(), image.height(), std::move(weights), data_->picture.filter,
                 ImageBorder::kClamp, std::move(measures));
  } else if constexpr (MeshOf<Surface>::kPatches) {
    for (std::size_t i = 0; i < data_->surface.size(); ++i)
      if (!is_corner_to_corner(i) || !data_->surface.primitive(i).is_unfolded())
        return std::nullopt;
    made.emplace(image, data_->picture.filter, ImageBorder::kClamp);
  }
  if constexpr (MeshOf<Surface>::kTriangles)
    if (missing_in_first()) made.emplace(image, data_->picture.filter, ImageBorder::kClamp);
  // A black picture may return any point.
  if (made && !(made->integral() > 0)) made.reset();
  return made;
}

template <typename Surface>
ShapeSample Painted<Surface>::sample(const Receiver& receiver, Vec2 u) const {
  if (!data_->distribution) return data_->surface.sample(receiver, u);
  ShapeSample s;
  if constexpr (kHasRows<Surface>) {
    const Vec2 at = data_->distribution->sample({u.x, u.y}).position;
    // Within a row of cells, points are chosen by area.  The part above the point is its share of
    // the row.
    const Band row = row_of_cells(data_->picture, at.y);
    const double share = std::clamp((at.y - row.above) / row.height, 0.0, 1.0);
    const double above =
        area_above(data_->surface, row.above) + share * data_->surface.area_of(row).share;
    s.point = data_->surface.at_shares({at.x, std::clamp(1 - above, 0.0, 1.0)});
  } else if constexpr (MeshOf<Surface>::kPatches) {
    const auto [i, within] = data_->surface.choose(u);
    const Vec2 at = data_->distribution->sample({within.x, within.y}).position;
    const Vec2 st = on_patch(i, {at.x, 1 - at.y});
    const Vec2 rounded{st.x, st.y};
    const auto& patch = data_->surface.primitive(i);
    s.point = {patch.at(rounded), patch.normal(rounded), static_cast<std::uint32_t>(i)};
  } else if constexpr (MeshOf<Surface>::kTriangles) {
    // Two triangles: the first shows the half of the picture opposite to its missing corner.
    const Vec2 at = data_->distribution->sample({u.x, u.y}).position, lacks = *missing_in_first();
    const double v = 1 - at.y;
    const std::uint32_t i = std::fabs(at.x - lacks.x) + std::fabs(v - lacks.y) >= 1 ? 0 : 1;
    const Vec2f* uv = &data_->corner_uv[3 * i];
    const double u1 = uv[1].x - uv[0].x, v1 = uv[1].y - uv[0].y;
    const double u2 = uv[2].x - uv[0].x, v2 = uv[2].y - uv[0].y;
    const double du = at.x - uv[0].x, dv = v - uv[0].y, determinant = u1 * v2 - v1 * u2;
    const double second = (du * v2 - dv * u2) / determinant,
                 third = (u1 * dv - v1 * du) / determinant;
    const auto& t = data_->surface.primitive(i);
    const Vec3 a(t.a), e = t.b - a, f = t.c - a;
    s.point = {a + e * second + f * third, t.normal(), i};
  }
  s.pdf = pdf(receiver, s.point);
  return s;
}

template <typename Surface>
AreaPdf Painted<Surface>::pdf_area(const SurfacePoint& point) const {
  if (!data_->distribution) return data_->surface.pdf_area(point);
  const Vec2 at = uv(point);
  const double y = 1 - at.y;
  if constexpr (kHasRows<Surface>) {
    const Band row = row_of_cells(data_->picture, y);
    const double measure = data_->surface.area_of(row).share;
    const double within = std::max(0.0, y - row.above);
    // Stay off the edges, which belong to the neighbours.
    const double share = std::clamp(
        data_->surface.area_of({row.above, within, 1 - y}).share / measure, 0x1p-30, 1 - 0x1p-30);
    const double of_square = data_->distribution->pdf({at.x, row.above + row.height * share});
    return {of_square * row.height / measure / this->area()};
  } else if constexpr (MeshOf<Surface>::kPatches) {
    if (point.primitive >= data_->surface.size()) return {0};
    const double element =
        data_->surface.primitive(point.primitive).area_element(on_patch(point.primitive, at));
    return {data_->surface.share(point.primitive) * data_->distribution->pdf({at.x, y}) / element};
  } else {
    if (point.primitive >= 2) return {0};
    // Each has half of the picture.
    return {data_->distribution->pdf({at.x, y}) / 2 /
            (data_->surface.share(point.primitive) * this->area())};
  }
}

template <typename Surface>
SolidAnglePdf Painted<Surface>::pdf(const Receiver& receiver, const SurfacePoint& point) const {
  if (!data_->distribution) return data_->surface.pdf(receiver, point);
  return as_seen_from(receiver.position, point, pdf_area(point));
}

template <typename Surface>
std::size_t Painted<Surface>::bytes() const {
  return sizeof(Data) - sizeof(data_->surface) + data_->surface.bytes() +
         data_->corner_uv.capacity() * sizeof(Vec2f) +
         (data_->distribution ? data_->distribution->bytes() - sizeof(*data_->distribution) : 0);
}

#define LUCERNA_PAINTED(Shape) template class Painted<Shape>;
LUCERNA_AREA_SHAPES(LUCERNA_PAINTED)

}  // namespace lucerna
