// Row 7: receivers exactly on triangles and quadrilaterals.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/on_light.h"

namespace lucerna::testing {
namespace {

TEST(OnLightExtremes, Triangles) {
  Sweep sweep(7, "receiver on a triangle: at vertices, on edges, inside", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      const Vec3 a = f.point(1, 2, 3), b = f.point(9, -6, 11), c = f.point(-7, 10, 19);
      const auto light = AreaLight::create({Rgb(1), two_sided}, *TriangleMesh::create({{a, b, c}}));
      const Vec3 normal = normalized(cross(b - a, c - a));
      // Shares of a, b and c in eighths, so that all points are exact.
      for (const Vec3& share : {Vec3{8, 0, 0},
                                {0, 8, 0},
                                {0, 0, 8},
                                {4, 4, 0},
                                {0, 4, 4},
                                {6, 0, 2},
                                {2, 2, 4},
                                {1, 3, 4},
                                {3, 3, 2}}) {
        const Vec3 on = a + (b - a) * (share.y / 8) + (c - a) * (share.z / 8);
        record_samples(*light, on, sweep);
        textbook(Vec3f(a * 0.5 + b * 0.25 + c * 0.25) - Vec3f(on), Vec3f(normal),
                 static_cast<float>(light->shape().area()), sweep);
      }
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Rectangles) {
  Sweep sweep(7, "receiver on a rectangle: at corners, on edges, inside", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true})
      for (const bool tilted : {false, true}) {
        // (2, 1, 2) and (1, 2, -2) are at right angles and have length 3.
        const auto at = [&](double u, double v) {
          return tilted ? f.point(2 * u + v, u + 2 * v, 2 * u - 2 * v) : f.point(3 * u, 5 * v, 0);
        };
        const auto light = AreaLight::create(
            {Rgb(1), two_sided}, *PatchMesh::create({{at(0, 0), at(4, 0), at(0, 8), at(4, 8)}}));
        for (const Vec2& p : {Vec2{0, 0},
                              {4, 0},
                              {0, 8},
                              {4, 8},
                              {2, 0},
                              {0, 5},
                              {4, 3},
                              {1, 8},
                              {2, 4},
                              {1, 7},
                              {3, 0.5}}) {
          record_samples(*light, at(p.x, p.y), sweep);
          textbook(Vec3f(at(1, 1)) - Vec3f(at(p.x, p.y)),
                   Vec3f(normalized(cross(at(1, 0) - at(0, 0), at(0, 1) - at(0, 0)))),
                   static_cast<float>(light->shape().area()), sweep);
        }
      }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Trapezoids) {
  Sweep sweep(7, "receiver on a flat quadrilateral that is not a rectangle", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      // In the plane of (2, 1, 2) and (1, 2, -2): 4 times the first; 8 times the second and, on the
      // opposite side, 4 times.
      const auto at = [&](double u, double v) {
        return f.point(2 * u + v, u + 2 * v, 2 * u - 2 * v);
      };
      const auto light = AreaLight::create(
          {Rgb(1), two_sided}, *PatchMesh::create({{at(0, 0), at(4, 0), at(0, 8), at(4, 4)}}));
      for (const Vec2& p :
           {Vec2{0, 0}, {4, 0}, {0, 8}, {4, 4}, {2, 0}, {0, 5}, {4, 3}, {2, 6}, {1, 2}, {3, 0.5}})
        record_samples(*light, at(p.x, p.y), sweep);
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, BentPatchesFromTheirOwnCorner) {
  // The directions to (u, v, u v) from its corner 0 end where u or v is 1.  There the integral of
  // the sine of the elevation over the azimuth is pi / 6.
  Sweep sweep(7, "receiver at a corner of a bent patch, where all of it is visible",
              "sizes 2^-80 ... 2^60 m, offsets 0 ... 3 sizes", "mean of 1 / density");
  for (const Place& f : frames()) {
    // At 1e6 sizes from zero, the doubles next to the corner are farther apart than the patch is
    // bent.
    if (max_abs(f.offset) > 3 * f.size) continue;
    const auto light =
        patch_light({f.point(0, 0, 0), f.point(1, 0, 0), f.point(0, 1, 0), f.point(1, 1, 1)});
    const Receiver receiver(f.point(0, 0, 0));
    const Seen seen = seen_beside_diagonal(light, receiver);
    EXPECT_EQ(seen.without, 0) << f.size;
    sweep.compare(seen.solid_angle_sr, std::numbers::pi / 6,
                  fmt::format("size {} offset {}", f.size, max_abs(f.offset) / f.size));
    for (const double x : {0.0, 0.3, 1.0})
      for (const auto& u : {Vec2{x, 0}, {0, x}}) {
        // Along the edges, on which the receiver lies.
        const auto s = light.sample_li(receiver, u);
        EXPECT_NE(s.reason, NoLight::kNone);
        EXPECT_EQ(s.value.max_component(), 0);
      }
  }
  sweep.expect_within(1e-9);
}

TEST(OnLightExtremes, CornersWithRandomDigits) {
  Sweep sweep(7, "receiver at a corner of a triangle or a rectangle with random coordinates",
              kSwept, "answer");
  std::mt19937 random(7);
  std::uniform_real_distribution<double> digits(-1, 1);
  const auto any = [&] { return Vec3{digits(random), digits(random), digits(random)}; };
  for (const Place& f : frames())
    for (int i = 0; i < 20; ++i) {
      const auto at = [&f](const Vec3& p) { return f.point(p.x, p.y, p.z); };
      const Vec3 a = any(), e = any(), way = any();
      const Vec3 h = normalized(cross(e, way)) * 0.7;
      const DiffuseEmission emission{Rgb(1), i % 2 == 0};
      const auto triangle =
          AreaLight::create(emission, *TriangleMesh::create({{at(a), at(a + e), at(a + way)}}));
      const Vec3 within = (a * 2 + (a + e) + (a + way)) / 4;
      for (const Vec3& corner : {a, a + e, a + way}) {
        record_samples(*triangle, at(corner), sweep);
        textbook(Vec3f(at(within)) - Vec3f(at(corner)), Vec3f(normalized(cross(e, way))),
                 static_cast<float>(triangle->shape().area()), sweep);
      }
      const auto rectangle = AreaLight::create(
          emission, *PatchMesh::create({{at(a), at(a + e), at(a + h), at(a + e + h)}}));
      for (const Vec3& corner : {a, a + e, a + h, a + e + h})
        record_samples(*rectangle, at(corner), sweep);
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

}  // namespace
}  // namespace lucerna::testing
