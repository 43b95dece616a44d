// Row 7: receivers exactly on spheres, cylinders and disks.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/on_light.h"

namespace lucerna::testing {
namespace {

TEST(OnLightExtremes, CutSpheresAndRims) {
  Sweep sweep(7, "receiver on a sphere off its axes, on the rim of a cut sphere or a cylinder",
              kSwept, "answer");
  for (const Place& f : frames()) {
    const SphereParams whole{.radius_m = 9 * f.size,
                             .world_from_object = Transform::translate(f.point(1, 2, 3))};
    const auto ball = *AreaLight::create({Rgb(1)}, *Sphere::create(whole));
    for (const Vec3& p : {Vec3{1, 4, 8}, {-4, 7, 4}, {6, -3, -6}, {8, 4, -1}})
      record_samples(ball, f.point(1 + p.x, 2 + p.y, 3 + p.z), sweep);
    SphereParams part = whole;
    part.radius_m = 5 * f.size;
    part.z_min_m = -4 * f.size;
    part.z_max_m = 3 * f.size;
    const auto cut = *AreaLight::create({Rgb(1)}, *Sphere::create(part));
    for (const Vec3& p : {Vec3{4, 0, 3}, {0, -4, 3}, {-3, 0, -4}, {3, 4, 0}})
      record_samples(cut, f.point(1 + p.x, 2 + p.y, 3 + p.z), sweep);
    const auto tube = *AreaLight::create(
        {Rgb(1)}, *Cylinder::create({.radius_m = 5 * f.size,
                                     .z_min_m = -8 * f.size,
                                     .z_max_m = 8 * f.size,
                                     .world_from_object = whole.world_from_object}));
    for (const Vec3& p : {Vec3{5, 0, 8}, {3, 4, 8}, {-4, 3, -8}, {-3, -4, 1}})
      record_samples(tube, f.point(1 + p.x, 2 + p.y, 3 + p.z), sweep);
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, Disks) {
  Sweep sweep(7, "receiver on a disk: at the centre, on the rim, between", kSwept, "answer");
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      const auto at = Transform::translate(f.point(1, 2, 3));
      const auto light = AreaLight::create(
          {Rgb(1), two_sided}, *Disk::create({.radius_m = 4 * f.size, .world_from_object = at}));
      for (const Vec2& p : {Vec2{0, 0}, {4, 0}, {0, -4}, {-4, 0}, {1, 2}, {-3, 0.5}, {2, -2}}) {
        record_samples(*light, f.point(1 + p.x, 2 + p.y, 3), sweep);
        textbook(Vec3f(f.point(1, 2.5, 3)) - Vec3f(f.point(1 + p.x, 2 + p.y, 3)), {0, 0, 1},
                 static_cast<float>(light->shape().area()), sweep);
      }
    }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, SpheresAndCylindersFromOutside) {
  Sweep sweep(7, "receiver on a sphere or a cylinder that emits outwards", kSwept, "answer");
  for (const Place& f : frames()) {
    const auto at = Transform::translate(f.point(1, 2, 3));
    const auto ball = AreaLight::create(
        {Rgb(1)}, *Sphere::create({.radius_m = 4 * f.size, .world_from_object = at}));
    const auto tube = AreaLight::create({Rgb(1)}, *Cylinder::create({.radius_m = 4 * f.size,
                                                                     .z_min_m = -8 * f.size,
                                                                     .z_max_m = 8 * f.size,
                                                                     .world_from_object = at}));
    for (const Vec2& p : {Vec2{4, 0}, {0, -4}, {-4, 0}}) {
      const Vec3 on = f.point(1 + p.x, 2 + p.y, 3);
      record_samples(*ball, on, sweep);
      record_samples(*tube, on, sweep);
      textbook(Vec3f(f.point(1, 2, 7)) - Vec3f(on), {0, 0, 1},
               static_cast<float>(ball->shape().area()), sweep);
    }
  }
  sweep.expect_answers(NoLight::kDegenerate);
}

TEST(OnLightExtremes, SpheresFromWithin) {
  // A sampled point is rounded to the doubles at this distance from zero.  So it is off the sphere
  // by a rounding of its coordinates.  A radius is four sizes.
  Sweep sweep(7, "receiver on a sphere that shines inwards", kSwept,
              "density of sampled points against cos / pi");
  const auto bound = [](double offset_sizes) { return 1e-14 + 2 * 0x1p-53 * offset_sizes / 4; };
  double farthest = 0;
  for (const Place& f : frames()) farthest = std::fmax(farthest, max_abs(f.offset) / f.size);
  for (const Place& f : frames())
    for (const bool two_sided : {false, true}) {
      const SphereParams params{.radius_m = 4 * f.size,
                                .reverse_orientation = !two_sided,
                                .world_from_object = Transform::translate(f.point(1, 2, 3))};
      const auto light = AreaLight::create({Rgb(1), two_sided}, *Sphere::create(params));
      for (const Vec3& outwards : {Vec3{1, 0, 0}, {0, -1, 0}, {-1, 0, 0}, {0, 0, 1}})
        for (const double x : {0.125, 0.4, 0.75})
          for (const double y : {0.1, 0.3, 0.6, 0.9}) {
            const Receiver receiver(f.point(1, 2, 3) + outwards * params.radius_m);
            const auto sample = light->sample_li(receiver, {x, y});
            ASSERT_EQ(sample.reason, NoLight::kNone);
            const double cos = -dot(sample.wi, outwards), truth = cos / std::numbers::pi;
            const std::string at = fmt::format("size {}, u {}, {}", f.size, x, y);
            sweep.compare(sample.pdf.per_sr, truth, at);
            EXPECT_LE(relative_error(sample.pdf.per_sr, truth), bound(max_abs(f.offset) / f.size))
                << at;
            const Vec3f way = Vec3f(sample.point) - Vec3f(receiver.position);
            const float d2 = dot(way, way);
            const float cos_light = -dot(Vec3f(sample.normal), way) / std::sqrt(d2);
            sweep.compare_textbook(
                d2 / (std::fabs(cos_light) * static_cast<float>(light->shape().area())), truth);
          }
    }
  sweep.expect_within(bound(farthest));
}

}  // namespace
}  // namespace lucerna::testing
