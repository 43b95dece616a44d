// Row 25: angles between nearly parallel directions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/area_extremes.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

using V = Vec3;

TEST(AngleExtremes, ConeOfNormalsOfAHinge) {
  Sweep sweep(25, "mesh of two nearly coplanar triangles, angle between them", "1e-24 ... 0.5 rad",
              "half-angle of the cone of normals");
  const ReferenceTable table("hinges");
  for (const auto& row : table.rows()) {
    const double t = row["t"];
    const auto mesh = *TriangleMesh::create(
        {{V(0, 0, 0), V(1, 0, 0), V(0, 1, 0)}, {V(0, 0, 0), V(0, -1, t), V(1, 0, 0)}});
    sweep.compare(mesh.normals().half_angle_rad, row["widest_rad"], row.text("t"));
    const Vec3f n = normalized(Vec3f(0, static_cast<float>(t), 1));
    const Vec3f mean = normalized(n + Vec3f(0, 0, 1));
    sweep.compare_textbook(std::acos(mean.z), row["widest_rad"]);
  }
  sweep.expect_within(1e-14);
}

TEST(AngleExtremes, PhotometryNextToThePole) {
  Sweep sweep(25, "goniometric light whose intensity grows with the angle to its axis",
              "1e-24 ... 0.5 rad from the axis", "illuminance");
  const auto web = *PhotometricWeb::create(
      {.vertical_deg = {0, 90, 180}, .horizontal_deg = {0}, .intensity_cd = {0, 90, 0}});
  const auto light = *GoniometricLight::create({.intensity = Rgb(1), .web = web});
  const ReferenceTable table("hinges");
  for (const auto& row : table.rows()) {
    const double t = row["t"];
    sweep.compare(light.sample_li(V(t, 0, 1), {0.5, 0.5}).value.g, row["degrees_by_square"],
                  row.text("t"));
    const float cosine = normalized(Vec3f(static_cast<float>(t), 0, 1)).z;
    const float degrees = std::acos(cosine) * 180 / std::numbers::pi_v<float>;
    sweep.compare_textbook(degrees * cosine * cosine, row["degrees_by_square"]);
  }
  sweep.expect_within(1e-14);
}

TEST(AngleExtremes, ParallelUnitVectorsAreParallel) {
  Sweep sweep(25, "a unit vector and itself", "100000 directions", "angle");
  RandomU random(0x25);
  for (int i = 0; i < 100000; ++i) {
    const V a = normalized(V(random.next() - 0.5, random.next() - 0.5, random.next() - 0.5));
    const V side = normalized(cross(a, std::fabs(a.x) < 0.5 ? V(1, 0, 0) : V(0, 1, 0)));
    const Triangle triangle{V{}, side, cross(a, side)};
    const auto cone = TriangleMesh::create({triangle, triangle})->normals();
    sweep.answer(cone.half_angle_rad <= 0x1p-52 ? "parallel" : "not parallel");
    const Vec3f f = normalized(Vec3f(a));
    const float angle = std::acos(dot(f, f));
    sweep.textbook_answer(std::isnan(angle) ? "not a number"
                          : angle == 0      ? "parallel"
                                            : "an angle");
  }
  sweep.expect_answers("parallel");
}

}  // namespace
}  // namespace lucerna::testing
