#include "tests/oracle/oracle_lights.h"

namespace lucerna::oracle {
namespace {

/// The value of a picture over the unit square, whose corner (0, 0) is at the top left.
Real value_at(const Texels& picture, Real s, Real t) {
  if (picture.empty()) return 1;
  const auto index = [](Real x, int n) {
    return std::clamp(static_cast<int>(std::floor(x * n)), 0, n - 1);
  };
  return picture.at(index(s, picture.width), index(t, picture.height));
}

/// The ratio of width to height, and half of both where half of the shorter side is 1.
std::pair<Real, Real> halves(const Texels& picture) {
  if (picture.empty()) return {1, 1};
  const Real aspect = static_cast<Real>(picture.width) / picture.height;
  return aspect > 1 ? std::pair{aspect, Real{1}} : std::pair{Real{1}, 1 / aspect};
}

/// The place of a point of the picture's plane in the unit square.
std::optional<std::pair<Real, Real>> in_square(const Texels& picture, Real x, Real y) {
  const auto [half_x, half_y] = halves(picture);
  if (std::fabs(x) > half_x || std::fabs(y) > half_y) return std::nullopt;
  return std::pair{(1 + x / half_x) / 2, (1 - y / half_y) / 2};
}

Real smoothstep(Real x) {
  x = std::clamp(x, Real{0}, Real{1});
  return x * x * (3 - 2 * x);
}

/// Candela of a web at angles in degrees.
Real candela(const Light& light, Real gamma, Real azimuth) {
  const auto& gammas = light.gammas;
  if (gamma < gammas.front() || gamma > gammas.back()) return 0;
  std::size_t i = 0;
  while (i + 2 < gammas.size() && gamma > gammas[i + 1]) ++i;
  const Real share = (gamma - gammas[i]) / (gammas[i + 1] - gammas[i]);
  const auto in_plane = [&](int plane) {
    const std::size_t first = static_cast<std::size_t>(plane) * gammas.size() + i;
    return light.candela[first] * (1 - share) + light.candela[first + 1] * share;
  };
  if (light.planes == 1) return in_plane(0);
  // Mirrored into the planes that the file has.
  Real a = std::fabs(azimuth);
  if (light.sweep == 90 && a > 90) a = 180 - a;
  const Real at = a / light.sweep * (light.planes - 1);
  const int plane = std::clamp(static_cast<int>(at), 0, light.planes - 2);
  return in_plane(plane) * (plane + 1 - at) + in_plane(plane + 1) * (at - plane);
}

/// The solid angle of the rectangle from the origin of its plane to (x, y), seen from a distance of
/// 1 over the origin.
Real solid_angle(Real x, Real y) { return std::atan2(x * y, std::sqrt(1 + x * x + y * y)); }

Real flux_of_web(const Light& light) {
  // In azimuth the mean of the planes by the trapezoidal rule is exact.
  Real sum = 0;
  for (int plane = 0; plane < light.planes; ++plane) {
    const bool end = light.planes > 1 && (plane == 0 || plane == light.planes - 1);
    const Real weight = light.planes == 1 ? 1 : (end ? 0.5L : 1) / (light.planes - 1);
    for (std::size_t i = 0; i + 1 < light.gammas.size(); ++i) {
      const Real a = light.gammas[i] * kPi / 180, b = light.gammas[i + 1] * kPi / 180;
      const std::size_t first = static_cast<std::size_t>(plane) * light.gammas.size() + i;
      const Real p = light.candela[first], q = light.candela[first + 1];
      // The integral of (p + (q - p) (x - a) / (b - a)) sin x.
      sum += weight *
             (p * std::cos(a) - q * std::cos(b) + (q - p) / (b - a) * (std::sin(b) - std::sin(a)));
    }
  }
  return 2 * kPi * sum * light.level;
}

}  // namespace

Vec direction_of(Real s, Real t) {
  const Real x = 2 * s - 1, y = 2 * t - 1, ax = std::fabs(x), ay = std::fabs(y);
  const Real inner = 1 - (ax + ay), r = 1 - std::fabs(inner);
  const Real angle = r > 0 ? (ay - ax + r) / r * kPi / 4 : kPi / 4;
  const Real z = std::copysign(1 - r * r, inner), across = r * std::sqrt(2 - r * r);
  return {std::copysign(std::cos(angle) * across, x), std::copysign(std::sin(angle) * across, y),
          z};
}

std::pair<Real, Real> square_of(const Vec& w) {
  const Real ax = std::fabs(w.x), ay = std::fabs(w.y);
  const Real r = std::sqrt(std::fmax(0, 1 - std::fabs(w.z)));
  Real v = std::atan2(ay, ax) * 2 / kPi * r;
  Real u = r - v;
  if (w.z < 0) {
    const Real swapped = u;
    u = 1 - v;
    v = 1 - swapped;
  }
  return {(1 + std::copysign(u, w.x)) / 2, (1 + std::copysign(v, w.y)) / 2};
}

Real intensity(const Light& light, const Vec& w) {
  switch (light.kind) {
    case LightKind::kPoint:
      return light.level;
    case LightKind::kSpot: {
      const Real outer = std::cos(light.angle), inner = std::cos(light.angle - light.edge);
      return light.level * smoothstep((w.z - outer) / (inner - outer));
    }
    case LightKind::kPicture: {
      // The map's pole is the light's y axis, as in pbrt-v4.
      const auto [s, t] = square_of({w.x, w.z, w.y});
      return light.level * value_at(light.picture, s, t);
    }
    case LightKind::kWeb:
      return light.level * candela(light, std::atan2(std::hypot(w.x, w.y), w.z) * 180 / kPi,
                                   std::atan2(w.y, w.x) * 180 / kPi);
    case LightKind::kProjection: {
      if (w.z <= 0) return 0;
      const Real scale = std::tan(light.angle / 2) * w.z;
      const auto p = in_square(light.picture, w.x / scale, w.y / scale);
      return p ? light.level * value_at(light.picture, p->first, p->second) : 0;
    }
    default:
      return 0;
  }
}

std::optional<Arrival> arrival(const Light& light, const Vec& at, Real reach) {
  const auto& [u, v, w] = light.axes;
  switch (light.kind) {
    case LightKind::kSun:
    case LightKind::kSky:
    case LightKind::kPortal:
      return std::nullopt;
    case LightKind::kDistant:
      return Arrival{{.at = at + w * reach, .far = true}, light.level};
    case LightKind::kBeam: {
      const Vec d = at - light.at;
      const Real z = dot(d, w);
      const auto p =
          in_square(light.picture, dot(d, u) / light.extent[0], dot(d, v) / light.extent[0]);
      if (z <= 0 || !p) return Arrival{{.at = light.at}, 0};
      return Arrival{{.at = at - w * z},
                     light.level * value_at(light.picture, p->first, p->second)};
    }
    default: {
      const Vec d = at - light.at;
      const Real distance = length(d);
      const Vec local = Vec{dot(d, u), dot(d, v), dot(d, w)} * (1 / distance);
      return Arrival{{.at = light.at}, intensity(light, local) / (distance * distance)};
    }
  }
}

Real flux(const Light& light) {
  switch (light.kind) {
    case LightKind::kPoint:
      return 4 * kPi * light.level;
    case LightKind::kSpot: {
      // The integral of a smoothstep over its edge is half of the edge.
      const Real outer = std::cos(light.angle), inner = std::cos(light.angle - light.edge);
      return 2 * kPi * light.level * (1 - (inner + outer) / 2);
    }
    case LightKind::kPicture: {
      Real sum = 0;
      for (const Real x : light.picture.values) sum += x;
      return 4 * kPi * light.level * sum / static_cast<Real>(light.picture.values.size());
    }
    case LightKind::kWeb:
      return flux_of_web(light);
    case LightKind::kProjection:
    case LightKind::kBeam: {
      const auto [half_x, half_y] = halves(light.picture);
      const int width = light.picture.empty() ? 1 : light.picture.width;
      const int height = light.picture.empty() ? 1 : light.picture.height;
      const bool beam = light.kind == LightKind::kBeam;
      const Real scale = beam ? light.extent[0] : std::tan(light.angle / 2);
      const auto x = [&](int i) { return half_x * scale * (2.0L * i / width - 1); };
      const auto y = [&](int j) { return half_y * scale * (2.0L * j / height - 1); };
      Real sum = 0;
      for (int j = 0; j < height; ++j) {
        for (int i = 0; i < width; ++i) {
          const Real value = light.picture.empty() ? 1 : light.picture.at(i, j);
          const auto part = [&](Real a, Real b) { return beam ? a * b : solid_angle(a, b); };
          sum += value * (part(x(i + 1), y(j + 1)) - part(x(i), y(j + 1)) - part(x(i + 1), y(j)) +
                          part(x(i), y(j)));
        }
      }
      return light.level * sum;
    }
    default:
      return 0;
  }
}

}  // namespace lucerna::oracle
