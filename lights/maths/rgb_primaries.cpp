#include "lights/maths/rgb_primaries.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lucerna {
namespace {

using Rows = std::array<Vec3, 3>;

Rows transposed(const Rows& m) {
  return {{{m[0].x, m[1].x, m[2].x}, {m[0].y, m[1].y, m[2].y}, {m[0].z, m[1].z, m[2].z}}};
}

Vec3 times(const Rows& m, const Vec3& v) { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }

Rows times(const Rows& a, const Rows& b) {
  const Rows columns = transposed(b);
  return transposed({times(a, columns[0]), times(a, columns[1]), times(a, columns[2])});
}

/// Nothing if the determinant is 0 or not finite.
std::optional<Rows> inverse(const Rows& m) {
  const Vec3 a = cross(m[1], m[2]), b = cross(m[2], m[0]), c = cross(m[0], m[1]);
  const double determinant = dot(m[0], a);
  if (!(std::fabs(determinant) > 1e-9) || !std::isfinite(determinant)) return std::nullopt;
  return transposed({a / determinant, b / determinant, c / determinant});
}

/// X, Y and Z of a chromaticity.  Their sum is 1.
Vec3 xyz_of(const Vec2& xy) { return {xy.x, xy.y, 1 - xy.x - xy.y}; }

/// X, Y and Z of a white of luminance 1.
Vec3 white_of(const RgbPrimaries& p) { return xyz_of(p.white) / p.white.y; }

/// The amounts of the primaries are such that their sum is the white.
std::optional<Rows> xyz_from_rgb(const RgbPrimaries& p) {
  const Rows primaries = transposed({xyz_of(p.red), xyz_of(p.green), xyz_of(p.blue)});
  const auto amounts_from_xyz = inverse(primaries);
  if (!amounts_from_xyz || !(p.white.y > 1e-6)) return std::nullopt;
  const Vec3 amounts = times(*amounts_from_xyz, white_of(p));
  if (!(std::min({amounts.x, amounts.y, amounts.z}) > 0) || !is_finite(amounts))
    return std::nullopt;
  const auto scaled = [&](const Vec3& row) {
    return Vec3{row.x * amounts.x, row.y * amounts.y, row.z * amounts.z};
  };
  return Rows{{scaled(primaries[0]), scaled(primaries[1]), scaled(primaries[2])}};
}

/// [Lam85]
std::optional<Rows> bradford(const Vec3& from, const Vec3& to) {
  constexpr Rows kCones{
      {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
  const Vec3 before = times(kCones, from), after = times(kCones, to);
  if (!(std::min({before.x, before.y, before.z}) > 0)) return std::nullopt;
  const Rows scaled{{kCones[0] * (after.x / before.x), kCones[1] * (after.y / before.y),
                     kCones[2] * (after.z / before.z)}};
  return times(*inverse(kCones), scaled);
}

}  // namespace

const RgbPrimaries* named_primaries(std::string_view name) {
  static constexpr std::pair<std::string_view, RgbPrimaries> kNamed[]{
      {"srgb", kRec709},
      {"dci-p3", {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, kRec709.white}},
      {"rec2020", {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, kRec709.white}},
      {"aces2065-1", {{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, {0.32168, 0.33767}}},
  };
  const auto is_name = [&](const auto& named) {
    return std::ranges::equal(name, named.first, [](char a, char b) {
      return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b;
    });
  };
  const auto* found = std::ranges::find_if(kNamed, is_name);
  return found == std::end(kNamed) ? nullptr : &found->second;
}

std::optional<RgbConversion> RgbConversion::to_rec709(const RgbPrimaries& from, White white) {
  const auto xyz = xyz_from_rgb(from);
  if (!xyz) return std::nullopt;
  Rows rgb_from_xyz = *inverse(*xyz_from_rgb(kRec709));
  if (white == White::kAdapted) {
    const auto adapted = bradford(white_of(from), white_of(kRec709));
    if (!adapted) return std::nullopt;
    rgb_from_xyz = times(rgb_from_xyz, *adapted);
  }
  return RgbConversion(times(rgb_from_xyz, *xyz));
}

bool is_outside_rec709(const Rgb& c) {
  return std::min({c.r, c.g, c.b}) < -1e-6 * std::fabs(c.max_component());
}

Rgb at_edge_of_rec709(const Rgb& c) {
  if (std::min({c.r, c.g, c.b}) >= 0) return c;
  const double wanted = luminance(c);
  const Rgb rest{std::max(c.r, 0.0), std::max(c.g, 0.0), std::max(c.b, 0.0)};
  return wanted > 0 ? rest * (wanted / luminance(rest)) : Rgb();
}

}  // namespace lucerna
