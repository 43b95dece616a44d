// Row 39: segments in the plane of a tilted sheet.  They end before they reach it, but their lines
// go through it.  Rounding decides where such a line meets the plane.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/scene/scene.h"
#include "tests/extremes_sweep.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

TEST(CoplanarExtremes, SegmentsThatEndBeforeTheSheet) {
  Sweep sweep(39, "segments in the plane of a tilted sheet, which end before it",
              "sheets of 1e-6 ... 1e6 m", "blocked");
  std::mt19937 random(39);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto direction = [&] { return normalized(Vec3{unit(random), unit(random), unit(random)}); };
  constexpr int kSheets = 40, kSegments = 2000;
  std::int64_t wrong = 0, cases = 0;
  for (int i = 0; i < kSheets; ++i) {
    const double size = std::pow(10.0, 6 * unit(random));
    const Vec3 n = direction(), u = normalized(cross(n, direction())), v = cross(n, u);
    const Vec3 corner = direction() * size, s = u * size, t = (v + u * unit(random)) * size;
    SceneDescription d = description();
    if (i % 2 == 0)
      d.shapes = {patch(corner, corner + s, corner + t, corner + s + t)};
    else
      d.shapes = {shape(TriangleMeshData{
          .positions = {corner, corner + s, corner + t}, .normals = {}, .indices = {0, 1, 2}})};
    const auto scene = build(std::move(d));
    for (int k = 0; k < kSegments; ++k, ++cases) {
      // The end is at least a tenth of the size before the sheet.
      const Vec3 target = corner + (s + t) * (0.3 + 0.1 * unit(random));
      const double angle = 3.14 * unit(random);
      const Vec3 way = u * std::cos(angle) + v * std::sin(angle);
      const double near = size * (2.5 + unit(random)), far = near + size * (1.1 + unit(random));
      const Ray ray{Vec3f(target + way * far - scene->origin()), Vec3f(way * (near - far)), 0, 1,
                    0};
      if (scene->geometry().occluded(ray) || scene->geometry().accelerator().closest_hit(ray))
        ++wrong;
    }
  }
  sweep.expect_none(wrong, cases, 0);
}

}  // namespace
}  // namespace lucerna::testing
