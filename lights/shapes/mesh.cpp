#include "lights/shapes/mesh.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <type_traits>

#include "lights/maths/stop_poll.h"
#include "lights/sampling/projected_solid_angle.h"
#include "lights/sampling/sobol.h"

namespace lucerna {

namespace {

/// u.x with additional digits from u.y below its 24 bits.  A float has too few digits to choose
/// among millions of primitives and a place within one.  A hash scatters the digits of u.y, so they
/// are nearly independent of u.y.  All u.x with the same u.y shift equally, so u.x stays uniform.
double refined(Vec2 u) {
  const auto bits = std::bit_cast<std::uint64_t>(static_cast<double>(u.y));
  return u.x + std::ldexp(static_cast<double>(mix_bits(bits) >> 40), -48);
}

/// Whether `uv` is a corner of the picture.
bool is_corner(const Vec2& uv) { return (uv.x == 0 || uv.x == 1) && (uv.y == 0 || uv.y == 1); }

/// The corners in order around the primitive.
std::array<Vec3, 3> around(const Triangle& t) { return {t.a, t.b, t.c}; }
std::array<Vec3, 4> around(const BilinearPatch& p) { return {p.p00, p.p10, p.p11, p.p01}; }

absl::Status check_uv(const std::vector<Vec2f>& corner_uv, std::size_t corners) {
  if (!corner_uv.empty() && corner_uv.size() != corners)
    return absl::InvalidArgumentError(
        fmt::format("painted.corner_uv has {} entries, allowed: one for each of {} corners",
                    corner_uv.size(), corners));
  StopPoll poll;
  for (std::size_t i = 0; i < corner_uv.size(); ++i, poll())
    if (!std::isfinite(corner_uv[i].x) || !std::isfinite(corner_uv[i].y))
      return absl::InvalidArgumentError(fmt::format(
          "painted.corner_uv[{}] = ({}, {}), allowed: finite", i, corner_uv[i].x, corner_uv[i].y));
  return absl::OkStatus();
}

}  // namespace

template <typename Primitive>
Mesh<Primitive>::Mesh(std::vector<Primitive> primitives, std::vector<double> cumulative_area,
                      double area_error_m2, std::vector<bool> rectangles, std::vector<bool> flat,
                      std::vector<Vec2f> corner_uv)
    : primitives_(std::move(primitives)),
      cumulative_area_(std::move(cumulative_area)),
      area_error_m2_(area_error_m2),
      rectangles_(std::move(rectangles)),
      flat_(std::move(flat)),
      corner_uv_(std::move(corner_uv)),
      normals_(cone_of_normals()),
      bounds_(box()) {}

template <typename Primitive>
absl::StatusOr<Mesh<Primitive>> Mesh<Primitive>::create(std::vector<Primitive> primitives,
                                                        std::vector<Vec2f> corner_uv) {
  if (primitives.empty())
    return absl::InvalidArgumentError("mesh.primitives has 0 entries, allowed: at least 1");
  if (primitives.size() > std::numeric_limits<std::uint32_t>::max())
    return absl::InvalidArgumentError(
        fmt::format("mesh.primitives has {} entries, allowed: less than 2^32", primitives.size()));
  if (const auto status = check_uv(corner_uv, kCorners * primitives.size()); !status.ok())
    return status;
  std::vector<double> cumulative;
  cumulative.reserve(primitives.size());
  std::vector<bool> rectangles, flat;
  double sum = 0, error = 0;
  StopPoll poll;
  for (std::size_t i = 0; i < primitives.size(); ++i, poll()) {
    double area = 0;
    if constexpr (kAlwaysHasWays) {
      area = primitives[i].area();
    } else {
      const BilinearPatchArea measured = primitives[i].measure();
      area = measured.m2, error += measured.error_m2;
    }
    const auto [lower, upper] = primitives[i].bounds();
    if (!std::isfinite(area) || !is_finite(lower) || !is_finite(upper))
      return absl::InvalidArgumentError(fmt::format(
          "mesh.primitives[{}] has a vertex that is not finite or too large, allowed: finite "
          "vertices and area",
          i));
    sum += area;
    cumulative.push_back(sum);
    if constexpr (!kAlwaysHasWays) {
      rectangles.push_back(primitives[i].is_rectangle());
      flat.push_back(rectangles.back() || primitives[i].is_flat());
    }
  }
  if (!(sum > 0) || !std::isfinite(sum))
    return absl::InvalidArgumentError(
        fmt::format("mesh.area = {} m2, allowed: finite and > 0", sum));
  return Mesh(std::move(primitives), std::move(cumulative), error, std::move(rectangles),
              std::move(flat), std::move(corner_uv));
}

template <typename Primitive>
typename Mesh<Primitive>::Choice Mesh<Primitive>::choose(Vec2 u) const {
  if (primitives_.size() == 1) return {0, u};
  const double wide = refined(u);
  const double target = (wide < 1 ? wide : wide - std::floor(wide)) * area();
  // The first sum above the target belongs to a primitive with an area.
  auto chosen = std::upper_bound(cumulative_area_.begin(), cumulative_area_.end(), target);
  if (chosen == cumulative_area_.end())
    chosen = std::lower_bound(cumulative_area_.begin(), cumulative_area_.end(), area());
  const auto i = static_cast<std::size_t>(chosen - cumulative_area_.begin());
  const double before = i == 0 ? 0 : cumulative_area_[i - 1];
  u.x = std::clamp((target - before) / (*chosen - before), 0.0, 1.0);
  return {i, u};
}

template <typename Primitive>
ShapeSample Mesh<Primitive>::sample(const Receiver& receiver, Vec2 u) const {
  const auto [i, within] = choose(u);
  const auto choose_point = [&, i = i, within = within] {
    if constexpr (!kAlwaysHasWays)
      if (!has_ways(i)) {
        ShapeSample by_area = primitives_[i].sample_area(receiver, within);
        by_area.point.primitive = static_cast<std::uint32_t>(i);
        if (is_flat(i)) by_area.pdf = {pdf_by_area(receiver, by_area.point)};
        return by_area;
      }
    return primitives_[i].sample(receiver, within);
  };
  const ShapeSample chosen = choose_point();
  ShapeSample s{chosen.point, {share(i) * chosen.pdf.per_sr}, chosen.to_point};
  s.point.primitive = static_cast<std::uint32_t>(i);
  return s;
}

template <typename Primitive>
double Mesh<Primitive>::pdf_by_area(const Receiver& receiver, const SurfacePoint& point) const {
  const AreaPdf by_area = primitives_[point.primitive].pdf_area(point.position);
  if (const auto height = height_over(point, receiver.position))
    return pdf_seen_from(receiver.position, point, by_area, *height).per_sr;
  return pdf_seen_from(receiver.position, point, by_area).per_sr;
}

template <typename Primitive>
SolidAnglePdf Mesh<Primitive>::pdf(const Receiver& receiver, const SurfacePoint& point) const {
  if (point.primitive >= primitives_.size()) return {0};
  const std::size_t i = point.primitive;
  const double pdf =
      has_ways(i) ? primitives_[i].pdf(receiver, point).per_sr : pdf_by_area(receiver, point);
  return {share(i) * pdf};
}

template <typename Primitive>
void Mesh<Primitive>::for_each_hit(const Vec3& position, const Vec3& wi,
                                   absl::FunctionRef<void(const SurfacePoint&)> f) const {
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    auto found = primitives_[i].hits(position, wi, 0, std::numeric_limits<double>::infinity());
    for (int k = 0; k < found.count; ++k) {
      found.hit[k].point.primitive = static_cast<std::uint32_t>(i);
      f(found.hit[k].point);
    }
  }
}

template <typename Primitive>
double Mesh<Primitive>::height_above(const Vec3& p, const Vec3& n) const {
  const auto upmost = [](double at, double low, double high, double along) {
    return std::max((low - at) * along, (high - at) * along);
  };
  const auto& [lower, upper] = bounds_;
  const double of_box = upmost(p.x, lower.x, upper.x, n.x) + upmost(p.y, lower.y, upper.y, n.y) +
                        upmost(p.z, lower.z, upper.z, n.z);
  if (of_box <= 0 || primitives_.size() > kMany) return of_box;
  double highest = -std::numeric_limits<double>::infinity();
  for (const auto& primitive : primitives_)
    for (const Vec3& corner : around(primitive)) highest = std::max(highest, dot(corner - p, n));
  return highest;
}

template <typename Primitive>
std::pair<Vec3, Vec3> Mesh<Primitive>::box() const {
  auto [lower, upper] = primitives_.front().bounds();
  StopPoll poll;
  for (const auto& primitive : primitives_) {
    poll();
    const auto [l, h] = primitive.bounds();
    lower = {std::min(lower.x, l.x), std::min(lower.y, l.y), std::min(lower.z, l.z)};
    upper = {std::max(upper.x, h.x), std::max(upper.y, h.y), std::max(upper.z, h.z)};
  }
  return {lower, upper};
}

template <typename Primitive>
std::size_t Mesh<Primitive>::bytes() const {
  return sizeof(*this) + primitives_.capacity() * sizeof(Primitive) +
         cumulative_area_.capacity() * sizeof(double) +
         (rectangles_.capacity() + flat_.capacity()) / 8 + corner_uv_.capacity() * sizeof(Vec2f);
}

template <typename Primitive>
std::optional<double> Mesh<Primitive>::projected_solid_angle_sr(const Vec3& position,
                                                                const Vec3& normal,
                                                                bool two_sided) const {
  double sum = 0;
  StopPoll poll;
  for (std::size_t i = 0; i < primitives_.size(); ++i, poll()) {
    if (!(share(i) > 0)) continue;
    if (!is_flat(i)) return std::nullopt;
    const double height = primitives_[i].height_of(position);
    if (two_sided || height > 0)
      sum += polygon_projected_solid_angle(around(primitives_[i]), position, normal, height);
  }
  return sum;
}

template <typename Primitive>
bool Mesh<Primitive>::hides_itself() const {
  // The largest primitive has the most exact plane.
  std::size_t largest = 0;
  StopPoll poll;
  for (std::size_t i = 1; i < size(); ++i, poll())
    if (share(i) > share(largest)) largest = i;
  const auto [lower, upper] = bounds();
  const double rounding = 8 * std::numeric_limits<double>::epsilon() *
                          (double{max_abs(lower)} + double{max_abs(upper)});
  for (std::size_t i = 0; i < size(); ++i, poll()) {
    if (!(share(i) > 0)) continue;
    if (!is_flat(i)) return true;
    for (const Vec3& corner : around(primitives_[i]))
      if (!(std::fabs(primitives_[largest].height_of(corner)) <= rounding)) return true;
  }
  return false;
}

template <typename Primitive>
AreaPdf Mesh<Primitive>::pdf_area(const SurfacePoint& point) const {
  const std::size_t i = point.primitive;
  if (i >= primitives_.size()) return {0};
  if constexpr (std::is_same_v<Primitive, Triangle>) {
    return {1 / area()};
  } else {
    return {share(i) * primitives_[i].pdf_area(point.position).per_m2};
  }
}

template <typename Primitive>
std::optional<SurfacePoint> Mesh<Primitive>::locate(const Vec3& position, double slack_m) const {
  double nearest = rounding_m(bounds()) + slack_m;
  std::optional<SurfacePoint> found;
  StopPoll poll;
  for (std::size_t i = 0; i < primitives_.size(); ++i, poll()) {
    // Primitives without area are not part of the light.
    if (cumulative_area_[i] == (i == 0 ? 0 : cumulative_area_[i - 1])) continue;
    const auto& primitive = primitives_[i];
    const auto index = static_cast<std::uint32_t>(i);
    const auto keep = [&](double distance, const auto& normal) {
      if (!(found ? distance < nearest : distance <= nearest)) return;
      nearest = distance;
      found = SurfacePoint{position, normal(), index};
    };
    if constexpr (std::is_same_v<Primitive, Triangle>) {
      keep(primitive.distance_to(position), [&] { return primitive.normal(); });
    } else {
      const Vec2 uv = primitive.locate(position);
      keep(length(primitive.at(uv) - position), [&] { return primitive.normal(uv); });
    }
  }
  return found;
}

template <typename Primitive>
NormalCone Mesh<Primitive>::cone_of_normals() const {
  // The normals of a bilinear patch are sums of the normals at its corners with positive weights.
  // So a cone that contains those and is not wider than a hemisphere contains all normals.
  const auto for_each_normal = [this](const auto& f) {
    StopPoll poll;
    for (std::size_t i = 0; i < primitives_.size(); ++i, poll()) {
      const double area = cumulative_area_[i] - (i == 0 ? 0 : cumulative_area_[i - 1]);
      if (!(area > 0)) continue;
      if constexpr (std::is_same_v<Primitive, Triangle>) {
        f(primitives_[i].normal(), area);
      } else {
        for (const Vec2 uv : {Vec2{0, 0}, Vec2{1, 0}, Vec2{0, 1}, Vec2{1, 1}, Vec2{0.5, 0.5}})
          f(primitives_[i].normal(uv), area);
      }
    }
  };
  Vec3 mean;
  for_each_normal([&](const Vec3& n, double a) { mean = mean + n * (a / area()); });
  NormalCone cone;
  const Vec3 axis(normalized(mean));
  if (!(length(mean) > 1e-6)) return cone;
  double widest = 0;
  for_each_normal([&](const Vec3& n, double) {
    if (n != Vec3{}) widest = std::max(widest, angle_between(axis, n));
  });
  constexpr bool kTriangles = std::is_same_v<Primitive, Triangle>;
  if (!kTriangles && widest > 0) widest += 4 * kInputRounding;
  if (!kTriangles && widest > std::numbers::pi / 2) return cone;
  cone.axis = axis;
  cone.half_angle_rad = std::min(widest, std::numbers::pi);
  return cone;
}

template <typename Primitive>
Vec2 Mesh<Primitive>::corner(std::size_t primitive, std::size_t corner) const {
  if (!corner_uv_.empty()) {
    const Vec2f& uv = corner_uv_[kCorners * primitive + corner];
    return {uv.x, uv.y};
  }
  if (kAlwaysHasWays) return {corner > 0 ? 1.0 : 0.0, corner > 1 ? 1.0 : 0.0};
  return {double(corner & 1), double(corner >> 1)};
}

template <typename Primitive>
bool Mesh<Primitive>::is_corner_to_corner(std::size_t patch) const {
  // Tests that the corners are those of the square in one of its eight symmetries.  The edges from
  // the first corner are then the axes.
  const Vec2 a = corner(patch, 0), b = corner(patch, 1), c = corner(patch, 2), d = corner(patch, 3);
  return is_corner(a) && is_corner(b) && is_corner(c) && is_corner(d) && b.x + c.x == a.x + d.x &&
         b.y + c.y == a.y + d.y && std::fabs(b.x - a.x) + std::fabs(b.y - a.y) == 1 &&
         std::fabs(c.x - a.x) + std::fabs(c.y - a.y) == 1 &&
         (b.x - a.x) * (c.x - a.x) + (b.y - a.y) * (c.y - a.y) == 0;
}

template <typename Primitive>
std::optional<Vec2> Mesh<Primitive>::missing_in_first() const {
  if (!kAlwaysHasWays || size() != 2 || !(share(0) > 0 && share(1) > 0)) return std::nullopt;
  // The fourth corner of the square, which completes the parallelogram of the three others.
  const auto missing = [&](std::size_t triangle) -> std::optional<Vec2> {
    double x = 0, y = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 uv = corner(triangle, k);
      if (!is_corner(uv) || uv == corner(triangle, (k + 1) % 3)) return std::nullopt;
      x += uv.x, y += uv.y;
    }
    return Vec2{2 - x, 2 - y};
  };
  const auto first = missing(0), second = missing(1);
  if (!first || !second || first->x + second->x != 1 || first->y + second->y != 1)
    return std::nullopt;
  return first;
}

template <typename Primitive>
Vec2 Mesh<Primitive>::on_patch(std::size_t patch, Vec2 uv) const {
  const Vec2 a = corner(patch, 0), b = corner(patch, 1), c = corner(patch, 2);
  return {(uv.x - a.x) * (b.x - a.x) + (uv.y - a.y) * (b.y - a.y),
          (uv.x - a.x) * (c.x - a.x) + (uv.y - a.y) * (c.y - a.y)};
}

template <typename Primitive>
Vec2 Mesh<Primitive>::mixed(std::size_t patch, Vec2 st) const {
  const Vec2 a = corner(patch, 0), b = corner(patch, 1), c = corner(patch, 2), d = corner(patch, 3);
  const auto mix = [&](double a, double b, double c, double d) {
    return std::lerp(std::lerp(a, b, st.x), std::lerp(c, d, st.x), st.y);
  };
  return {mix(a.x, b.x, c.x, d.x), mix(a.y, b.y, c.y, d.y)};
}

template <typename Primitive>
Vec2 Mesh<Primitive>::uv(const SurfacePoint& point) const {
  const std::size_t i = point.primitive < size() ? point.primitive : 0;
  if constexpr (kAlwaysHasWays) {
    const Vec2 shares = primitives_[i].shares_at(point.position);
    const double s = std::clamp(shares.x, 0.0, 1.0), r = std::clamp(shares.y, 0.0, 1.0);
    const Vec2 a = corner(i, 0), b = corner(i, 1), c = corner(i, 2);
    return {a.x + s * (b.x - a.x) + r * (c.x - a.x), a.y + s * (b.y - a.y) + r * (c.y - a.y)};
  } else {
    const Vec2 st = primitives_[i].locate(point.position);
    return corner_uv_.empty() ? st : mixed(i, st);
  }
}

template <typename Primitive>
PaintedArea Mesh<Primitive>::painted_area(const Picture& picture) const {
  PaintedArea whole;
  StopPoll poll;
  if constexpr (kAlwaysHasWays) {
    // Many triangles of a mesh have the same (u, v).
    std::map<std::array<double, 6>, Rgb> known;
    for (std::size_t i = 0; i < size(); ++i, poll()) {
      const std::array uv{corner(i, 0), corner(i, 1), corner(i, 2)};
      const auto [entry, is_new] =
          known.try_emplace({uv[0].x, uv[0].y, uv[1].x, uv[1].y, uv[2].x, uv[2].y});
      if (is_new) entry->second = mean_over_triangle(picture, uv);
      whole.m2 += entry->second * (share(i) * area());
    }
  } else {
    std::optional<PictureMoments> moments;
    for (std::size_t i = 0; i < size(); ++i, poll()) {
      const auto& patch = primitives_[i];
      std::optional<PaintedArea> part;
      if (is_corner_to_corner(i) && patch.is_unfolded()) {
        if (!moments) moments.emplace(picture);
        part = moments->times([&](Vec2 uv) { return patch.area_element(on_patch(i, uv)); },
                              patch.least_area_element());
      }
      if (!part)
        part = sum_over_points(
            picture, [&](Vec2 st) { return mixed(i, st); },
            [&](Vec2 st) { return patch.area_element(st); });
      whole.m2 += part->m2;
      whole.error_m2 += part->error_m2;
    }
  }
  return whole;
}

template <typename Primitive>
std::optional<ImageDistribution> Mesh<Primitive>::distribution(const Picture& picture) const {
  if constexpr (kAlwaysHasWays) {
    if (!missing_in_first()) return std::nullopt;
  } else {
    for (std::size_t i = 0; i < size(); ++i)
      if (!is_corner_to_corner(i) || !primitives_[i].is_unfolded()) return std::nullopt;
  }
  return if_not_black({*picture.image, picture.filter, ImageBorder::kClamp});
}

template <typename Primitive>
SurfacePoint Mesh<Primitive>::sample_picture(const Picture&, const ImageDistribution& distribution,
                                             Vec2 u) const {
  if constexpr (kAlwaysHasWays) {
    const Vec2 at = distribution.sample(u).position, lacks = *missing_in_first();
    const double v = 1 - at.y;
    const std::uint32_t i = std::fabs(at.x - lacks.x) + std::fabs(v - lacks.y) >= 1 ? 0 : 1;
    const Vec2 p = corner(i, 0), q = corner(i, 1), r = corner(i, 2);
    const double u1 = q.x - p.x, v1 = q.y - p.y, u2 = r.x - p.x, v2 = r.y - p.y;
    const double du = at.x - p.x, dv = v - p.y, determinant = u1 * v2 - v1 * u2;
    const double second = (du * v2 - dv * u2) / determinant,
                 third = (u1 * dv - v1 * du) / determinant;
    const Triangle& t = primitives_[i];
    return {t.a + (t.b - t.a) * second + (t.c - t.a) * third, t.normal(), i};
  } else {
    const auto [i, within] = choose(u);
    const Vec2 at = distribution.sample(within).position;
    const Vec2 st = on_patch(i, {at.x, 1 - at.y});
    return {primitives_[i].at(st), primitives_[i].normal(st), static_cast<std::uint32_t>(i)};
  }
}

template <typename Primitive>
AreaPdf Mesh<Primitive>::pdf_picture(const Picture&, const ImageDistribution& distribution,
                                     const SurfacePoint& point) const {
  const std::size_t i = point.primitive;
  if (i >= size()) return {0};
  const Vec2 at = uv(point);
  const double of_square = distribution.pdf({at.x, 1 - at.y});
  // Each of two triangles has half of the picture.
  if constexpr (kAlwaysHasWays)
    return {of_square / 2 / (share(i) * area())};
  else
    return {share(i) * of_square / primitives_[i].area_element(on_patch(i, at))};
}

template class Mesh<Triangle>;
template class Mesh<BilinearPatch>;

}  // namespace lucerna
