#include "tests/oracle/random_lights.h"

namespace lucerna::oracle {
namespace {

Real degrees(double x) { return static_cast<double>(x * kPi / 180); }

void add_web(Numbers& random, Light& light) {
  const int steps = 1 + random.below(4);
  const int last = random.chance(0.5) ? 90 : 180;
  for (int i = 0; i <= steps; ++i) light.gammas.push_back(static_cast<double>(last) * i / steps);
  light.planes = 1 + random.below(3);
  light.sweep = random.chance(0.5) ? 90 : 180;
  // All planes meet at the poles.
  const double down = random.between(0, 100), up = random.between(0, 100);
  for (int plane = 0; plane < light.planes; ++plane) {
    for (int i = 0; i <= steps; ++i) {
      const bool end = i == steps && last == 180;
      light.candela.push_back(i == 0 ? down : end ? up : random.between(0, 100));
    }
  }
}

}  // namespace

Texels random_texels(Numbers& random, int width, int height) {
  Texels texels{width, height, {}};
  for (int i = 0; i < width * height; ++i)
    texels.values.push_back(random.chance(0.2) ? 0 : random.below(16) / 8.0);
  texels.values[0] = 1;  // not all black
  return texels;
}

std::array<Vec, 3> random_frame(Numbers& random, const Vec& w) {
  const Vec u = across(w), v = cross(w, u);
  const Real angle = random.between(0, 6.25);
  const Vec x = u * std::cos(angle) + v * std::sin(angle);
  return {doubles(x), doubles(cross(w, x)), doubles(w)};
}

Light random_light(Numbers& random, const Stage& stage) {
  Light light;
  light.kind = static_cast<LightKind>(random.below(static_cast<int>(kLightNames.size())));
  light.level = random.power(-2, 2);
  light.at = stage.over(random.between(-1, 1), random.between(-1, 1), random.power(-2, 0.5));
  // Most lights shine to where the shapes are.
  const Vec target = stage.over(random.between(-1, 1), random.between(-1, 1), 0);
  light.axes =
      random_frame(random, random.chance(0.7) ? unit(target - light.at) : random.direction());
  const Real square = stage.scale * stage.scale;
  const auto candela = [&] { light.level = static_cast<double>(light.level * square); };
  const auto texels = [&] {
    return random_texels(random, 1 + random.below(3), 1 + random.below(3));
  };
  switch (light.kind) {
    case LightKind::kPoint:
      candela();
      break;
    case LightKind::kSpot:
      candela();
      light.angle = degrees(random.power(0.3, 1.94));
      light.edge = light.angle * random.power(-2, 0);
      break;
    case LightKind::kPicture: {
      candela();
      const int width = 1 << random.below(3);
      light.picture = random_texels(random, width, width);
      break;
    }
    case LightKind::kWeb:
      candela();
      add_web(random, light);
      break;
    case LightKind::kProjection:
      candela();
      if (random.chance(0.7)) light.picture = texels();
      light.angle = degrees(random.power(0.3, 2.2));
      break;
    case LightKind::kBeam:
      if (random.chance(0.7)) light.picture = texels();
      light.extent[0] = static_cast<double>(stage.scale * random.power(-1, 1));
      break;
    case LightKind::kDistant:
    case LightKind::kSun: {
      Vec d = random.direction();
      if (dot(d, stage.axis) < 0) d = -d;
      light.axes = random_frame(random, d);
      if (light.kind == LightKind::kSun) light.angle = degrees(random.power(-1, 2));
      break;
    }
    case LightKind::kSky:
      if (random.chance(0.5)) {
        const int width = 1 << random.below(3);
        light.picture = random_texels(random, width, width);
      }
      light.axes = random_frame(random, random.direction());
      break;
    case LightKind::kPortal:
      for (Real& side : light.extent)
        side = static_cast<double>(stage.scale * random.power(-1, 0.5));
      break;
  }
  return light;
}

}  // namespace lucerna::oracle
