// Row 33: rays that leave area lights nearly along their surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/sampling/sampling.h"
#include "lights/shapes/all_shapes.h"
#include "tests/extremes_sweep.h"

namespace lucerna::testing {
namespace {

/// The cosine of a direction, from the disk to which the square of `u` maps.  The distance m to the
/// edge is the same in disk and square, so the squared cosine is 1 - (1 - m)^2.
long double cosine_of(Vec2 u, bool two_sided) {
  long double x = u.x;
  const long double y = u.y;
  if (two_sided) x = u.x < 0.5 ? 2 * x : 2 * x - 1;
  const long double m = 2 * std::min({x, 1 - x, y, 1 - y});
  return std::sqrt(m * (2 - m));
}

float textbook_cosine(Vec2f u) {
  const Vec2f d = sample_concentric_disk(u);
  return std::sqrt(std::max(0.0F, 1 - d.x * d.x - d.y * d.y));
}

/// Lights that face +z.
template <typename F>
void for_each_level_light(bool two_sided, F&& f) {
  const DiffuseEmission one{Rgb(1), two_sided};
  f(*AreaLight::create(one, *TriangleMesh::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}})),
    "triangle");
  f(*AreaLight::create(one, *PatchMesh::create({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}})),
    "patch");
  f(*AreaLight::create(one, *Disk::create({})), "disk");
}

TEST(EmissionExtremes, CosinesOfRaysNearlyAlongTheSurface) {
  Sweep sweep(33, "sample values of rays that leave flat lights", "2^-38 ... 1 - 2^-52",
              "cosine of the direction");
  // Below these, 16 roundings of floats keep the samples away from the edge itself.
  for (int exponent = -38; exponent <= -1; ++exponent) {
    const double x = std::ldexp(1.0, exponent);
    for (const Vec2 u : {Vec2{x, 0.375}, {0.375, x}, {1 - x, 0.375}, {0.375, 1 - x}}) {
      for (const bool two_sided : {false, true}) {
        const long double truth = cosine_of(u, two_sided);
        if (truth == 0) continue;  // the edge itself
        for_each_level_light(two_sided, [&](const auto& light, const char* name) {
          const auto s = light.sample_le({0.25, 0.25}, u, {{}, 2});
          EXPECT_EQ(s.reason, NoLight::kNone);
          sweep.compare(std::fabs(s.direction.z), static_cast<double>(truth),
                        std::string(name) + " 2^" + std::to_string(exponent));
        });
      }
      if (exponent >= -24 && exponent < -1)
        sweep.compare_textbook(textbook_cosine({static_cast<float>(u.x), static_cast<float>(u.y)}),
                               static_cast<double>(cosine_of(u, false)));
    }
  }
  sweep.expect_within(1e-15);
}

}  // namespace
}  // namespace lucerna::testing
