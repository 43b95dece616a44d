// Row 43: light by way of mirrors and lenses, in scenes of any size, with lamps close to the mirror
// and with small lenses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "server/materials/fresnel.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/extremes_sweep.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

TEST(SmoothExtremes, MirrorsOfAnySize) {
  Sweep sweep(43, "a lamp before a mirror", "sizes 1e-9 ... 1e9 m, lamp at 1e-5 ... 1.5 sizes",
              "illuminance, with that of the mirror image");
  for (const double size_m : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9}) {
    for (const double gap : {1e-5, 1e-3, 0.1, 1.5}) {
      SceneDescription d = description();
      d.materials = {{.params = MetalParams{.eta = ColourValue{Rgb(1)}, .k = ColourValue{Rgb(4)}}}};
      const double s = size_m;
      d.shapes = {patch({2 * s, -16 * s, -16 * s}, {2 * s, 16 * s, -16 * s},
                        {2 * s, -16 * s, 16 * s}, {2 * s, 16 * s, 16 * s})};
      const Vec3 lamp{(2 - gap) * s, 0.5 * s, s}, image{(2 + gap) * s, 0.5 * s, s};
      const double candela = 100 * s * s;
      d.lights = {point_light(lamp, candela)};
      const auto scene = build(std::move(d));
      const Vec3 n{0.6, 0, 0.8};
      const auto error = static_cast<float>(1e-7 * s);
      const std::vector<IrradiancePoint> points{
          {Vec3{} - scene->origin(), {error, error, error}, n}};
      const IrradianceResult r = estimate_irradiance(
          *scene, points, {.samples_per_block = 1, .block_count = 16, .bounces = 1}, {});
      const auto arriving = [&](const Vec3& from) {
        return candela * dot(n, normalized(from)) / dot(from, from);
      };
      const double cosine = normalized(image).x;
      const double share = fresnel_conductor(cosine, Rgb(1), Rgb(4)).g;
      sweep.compare(luminance(r.points[0].irradiance_lx), arriving(lamp) + share * arriving(image),
                    fmt::format("size {} m, lamp at {} sizes", size_m, gap));
    }
  }
  sweep.expect_within(1e-6);
}

TEST(SmoothExtremes, BallsOfGlassOfAnySize) {
  Sweep sweep(43, "a point light behind a ball of glass; rays solved in double",
              "sizes 1e-9 ... 1e9 m, radius 1e-4 ... 0.2 sizes, at and away from the middle",
              "illuminance in its shadow");
  // tests/data/smooth/caustics.py: illuminance(Point(3, 100), GlassBall(1.5, radius, 1.5), radius,
  // 0, 0, 1).
  struct Ball {
    double radius, lux;
  };
  for (const double size_m : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9}) {
    for (const Ball& ball : {Ball{0.2, 3.49791752}, Ball{1e-2, 4.26472921e-3},
                             Ball{1e-3, 4.11330495e-5}, Ball{1e-4, 4.11658636e-7}}) {
      for (const bool is_away : {false, true}) {
        const double s = size_m;
        // Away from the middle of the scene, floats round where rays meet the ball.
        const Vec3 to = is_away ? Vec3{0.53 * s, 0.41 * s, 0.37 * s} : Vec3{};
        const auto at = [&](double x, double y, double z) {
          return to + Vec3{x * s, y * s, z * s};
        };
        SceneDescription d = description();
        d.materials = {{.params = DielectricParams{}}, {}};
        d.shapes = {shape(SphereParams{.radius_m = ball.radius * s,
                                       .world_from_object = Transform::translate(at(0, 0, 1.5))})};
        for (const double side : {-s, s}) {
          if (!is_away) break;
          const Vec3 p{7.1 * side, 3.3 * side, -5.7 * side}, dx{0.1 * s, 0, 0}, dy{0, 0.1 * s, 0};
          d.shapes.push_back(patch(p, p + dx, p + dy, p + dx + dy));
          d.shapes.back().material = 1;
        }
        d.lights = {point_light(at(0, 0, 3), 100 * s * s)};
        const auto scene = build(std::move(d));
        const auto error = static_cast<float>(1e-7 * s);
        const std::vector<IrradiancePoint> points{
            {at(ball.radius, 0, 0) - scene->origin(), {error, error, error}, {0, 0, 1}}};
        const IrradianceResult r =
            estimate_irradiance(*scene, points, {.samples_per_block = 64, .block_count = 16}, {});
        sweep.compare(luminance(r.points[0].irradiance_lx), ball.lux,
                      fmt::format("size {} m, radius {} sizes{}", size_m, ball.radius,
                                  is_away ? ", away from the middle" : ""));
      }
    }
  }
  sweep.expect_within(0.03);
}

}  // namespace
}  // namespace lucerna::testing
