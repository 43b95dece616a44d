// Rows 1 to 6, 8, 10 and 30: irradiance in closed form.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {
namespace {

Receiver receiver_in(const ReferenceTable::Row& row) {
  return receiver_in(row, AreaSampling::kAutomatic);
}

template <typename Light>
double served(const Light& light, const Receiver& receiver) {
  const auto lx = light.irradiance(receiver);
  return lx ? lx->g : std::nan("");
}

/// Lambert's sum by the textbook: angles by the arccosine, in floats.
float textbook_sum(std::span<const Vec3> corners, const Receiver& receiver) {
  float sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3f r(receiver.position);
    const Vec3f a = normalized(Vec3f(corners[i]) - r);
    const Vec3f b = normalized(Vec3f(corners[(i + 1) % corners.size()]) - r);
    sum += std::acos(dot(a, b)) * dot(normalized(cross(a, b)), Vec3f(receiver.normal));
  }
  return std::fabs(sum) / 2;
}

void compare_triangle(const ReferenceTable::Row& row, const std::array<Vec3, 3>& corners,
                      const std::string& truth, const std::string& at, Sweep& sweep,
                      bool textbook = true) {
  const Receiver receiver = receiver_in(row);
  sweep.compare(served(triangle_light(corners), receiver), row[truth], at);
  if (textbook) sweep.compare_textbook(textbook_sum(corners, receiver), row[truth]);
}

std::array<Vec3, 4> patch_in(const ReferenceTable::Row& row) {
  return {vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01"),
          vector_in(row, "p11")};
}

void compare_rectangle(const ReferenceTable::Row& row, const std::string& at, Sweep& sweep,
                       bool textbook = true) {
  const Receiver receiver = receiver_in(row);
  const auto p = patch_in(row);
  sweep.compare(served(patch_light(p), receiver), row["irradiance_lx"], at);
  if (textbook)
    sweep.compare_textbook(textbook_sum(std::array{p[0], p[1], p[3], p[2]}, receiver),
                           row["irradiance_lx"]);
}

TEST(ClosedFormExtremes, SmallTriangles) {
  Sweep sweep(4, "triangle light, closed form", "1e-3 ... 1e-36 sr", "irradiance");
  const ReferenceTable table("small_triangles");
  for (const auto& row : table.rows())
    compare_triangle(row, {vector_in(row, "a"), vector_in(row, "b"), vector_in(row, "c")},
                     "irradiance_lx", row.text("name") + " " + row.text("solid_angle_sr"), sweep);
  sweep.expect_within(1e-12);
}

TEST(ClosedFormExtremes, TrianglesAsWideAsTheHemisphere) {
  Sweep sweep(3, "triangle light, closed form", "height / size 1 ... 1e-20, corners up to 1e9",
              "irradiance");
  const ReferenceTable table("hemisphere_triangles");
  for (const auto& row : table.rows())
    compare_triangle(row, {vector_in(row, "a"), vector_in(row, "b"), vector_in(row, "c")},
                     "irradiance_lx", row.text("name") + " " + row.text("receiver_z"), sweep);
  sweep.expect_within(1e-12);
}

// The parts of a sliver would extend up to 1e15 if both directions were cut alike.
TEST(ClosedFormExtremes, Slivers) {
  Sweep sweep(34, "triangle light 2 m long, closed form",
              "3e-2 ... 1e-15 m high, receiver as near as the height", "irradiance");
  const ReferenceTable table("sliver_triangles");
  for (const auto& row : table.rows())
    compare_triangle(row, {vector_in(row, "a"), vector_in(row, "b"), vector_in(row, "c")},
                     "irradiance_lx", row.text("receiver_y"), sweep);
  sweep.expect_within(1e-12);
}

TEST(ClosedFormExtremes, SmallQuadrilaterals) {
  Sweep sweep(6, "rectangle or trapezoid light, closed form", "1e-1 ... 1e-36 sr", "irradiance");
  for (const char* name : {"small_rectangles", "small_quadrilaterals"}) {
    const ReferenceTable table(name);
    for (const auto& row : table.rows())
      compare_rectangle(row, row.text("name") + " " + row.text("solid_angle_sr"), sweep);
  }
  sweep.expect_within(1e-12);
}

TEST(ClosedFormExtremes, EdgeOnRectangles) {
  Sweep sweep(5, "rectangle light seen edge-on, closed form", "3.4e-3 ... 2e-8 sr", "irradiance");
  const ReferenceTable table("edge_on_rectangles");
  for (const auto& row : table.rows())
    compare_rectangle(row, row.text("name") + " " + row.text("p00_z"), sweep);
  sweep.expect_within(1e-12);
}

TEST(ClosedFormExtremes, GrazingPolygons) {
  Sweep sweep(8, "triangle or rectangle, receiver nearly in its plane, closed form",
              "cosine 1e-3 ... 1e-20, along axes and tilted", "irradiance");
  const ReferenceTable table("grazing_polygons");
  for (const auto& row : table.rows()) {
    const std::string at = row.text("name") + " " + row.text("height_m");
    compare_triangle(row, {vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01")},
                     "triangle_irradiance_lx", at, sweep);
    compare_rectangle(row, at, sweep);
  }
  sweep.expect_within(1e-11);
}

TEST(ClosedFormExtremes, PolygonsThatTheHorizonCuts) {
  Sweep sweep(8, "triangle or rectangle that the receiver's horizon cuts, closed form",
              "sizes, heights and visible parts 1 ... 1e-14", "irradiance");
  const ReferenceTable table("horizon_polygons");
  for (const auto& row : table.rows()) {
    const std::string at = row.text("name") + " " + row.text("size");
    if (row["triangle_irradiance_lx"] > 0)
      compare_triangle(row, {vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01")},
                       "triangle_irradiance_lx", "triangle " + at, sweep, false);
    compare_rectangle(row, at, sweep, false);
  }
  sweep.expect_within(1e-11);
}

AreaLight disk_light(double radius, const Transform& world_from_object) {
  return *AreaLight::create(
      {Rgb(1), true}, *Disk::create({.radius_m = radius, .world_from_object = world_from_object}));
}

TEST(ClosedFormExtremes, SmallLowAndGrazingDisks) {
  Sweep sweep(8, "disk light, closed form", "size / height and height / size 1 ... 1e-20",
              "irradiance");
  const ReferenceTable table("disks");
  for (const auto& row : table.rows()) {
    Receiver receiver(0, 0, 0);
    receiver.normal = vector_in(row, "normal");
    const auto light =
        disk_light(row["radius_m"], Transform::translate({row["offset_m"], 0, row["height_m"]}));
    sweep.compare(served(light, receiver), row["irradiance_lx"],
                  row.text("name") + " " + row.text("radius_m") + " " + row.text("height_m"));
  }
  sweep.expect_within(1e-13);
}

TEST(ClosedFormExtremes, DisksLevelWithTheReceiver) {
  Sweep sweep(8, "disk light nearly in the plane of the receiver's surface, closed form",
              "height / distance 1e-8 ... 1e-20", "irradiance");
  for (int k = 8; k <= 20; ++k) {
    // Both cosines are h / r.  Irradiance is h^2 times the integral of 1 / r^4, pi R^2 / (o^2 -
    // R^2)^2, with an error of order h^2.
    const double h = std::pow(10, -k), r = 0.5, o = 2;
    Receiver receiver(0, 0, 0);
    receiver.normal = {0, 0, 1};
    const double between = (o - r) * (o + r);
    sweep.compare(served(disk_light(r, Transform::translate({o, 0, h})), receiver),
                  std::numbers::pi * (r * h / between) * (r * h / between), std::to_string(k));
  }
  sweep.expect_within(1e-13);
}

/// The map that takes z to the unit vector `axis` and 0 to `center`.
Transform placed(const Vec3& center, const Vec3& axis) {
  const auto frame = Frame::around(axis);
  return *Transform::from_matrix({{{frame.s.x, frame.t.x, axis.x, center.x},
                                   {frame.s.y, frame.t.y, axis.y, center.y},
                                   {frame.s.z, frame.t.z, axis.z, center.z}}});
}

TEST(ClosedFormExtremes, DisksThatTheHorizonCuts) {
  Sweep sweep(8, "disk light that the receiver's horizon cuts, closed form",
              "sizes, heights and visible parts 1 ... 1e-13", "irradiance");
  const ReferenceTable table("horizon_disks");
  for (const auto& row : table.rows()) {
    Receiver receiver(0, 0, 0);
    receiver.normal = vector_in(row, "normal");
    const auto light =
        disk_light(row["radius_m"], placed(vector_in(row, "center"), vector_in(row, "axis")));
    sweep.compare(served(light, receiver), row["irradiance_lx"],
                  row.text("name") + " " + row.text("size"));
  }
  sweep.expect_within(1e-11);
}

AreaLight sphere_light(double radius, const Vec3& center) {
  SphereParams params;
  params.radius_m = radius;
  params.world_from_object = Transform::translate(center);
  return *AreaLight::create({Rgb(1)}, *Sphere::create(params));
}

TEST(ClosedFormExtremes, Spheres) {
  Sweep sweep(1, "sphere light above the receiver's horizon or cut by it, closed form",
              "radius / distance 1e-12 ... 1 - 1e-11", "irradiance");
  const ReferenceTable cone("sphere_cone");
  for (const auto& row : cone.rows()) {
    Receiver receiver(0, 0, 0);
    receiver.normal = {0, 0, 1};
    const double share = row["radius_m"] / row["distance_m"];
    sweep.compare(served(sphere_light(row["radius_m"], {0, 0, row["distance_m"]}), receiver),
                  std::numbers::pi * share * share, row.text("radius_m"));
  }
  const ReferenceTable cut("horizon_spheres");
  for (const auto& row : cut.rows()) {
    Receiver receiver(0, 0, 0);
    receiver.normal = {0, 0, 1};
    sweep.compare(served(sphere_light(row["radius_m"], {row["x"], 0, row["z"]}), receiver),
                  row["irradiance_lx"], "cut " + row.text("radius_m") + " " + row.text("z"));
  }
  // About 1e-6 of the radius remains.  One rounding of the radius changes it by 1e-10.
  sweep.expect_within(1e-9);
}

TEST(ClosedFormExtremes, JustOutsideOfSpheres) {
  Sweep sweep(2, "receiver just outside a sphere light, closed form", "gap / radius 0.1 ... 1e-15",
              "irradiance");
  const ReferenceTable table("sphere_near");
  for (const auto& row : table.rows()) {
    const auto lx = sphere_light(row["radius_m"], {}).irradiance(receiver_in(row));
    // At a gap of 1e-15 a double cannot separate the receiver from the surface.
    if (!lx && row["gap"] < 2e-15) continue;
    sweep.compare(lx ? lx->g : std::nan(""), row["irradiance_lx"], row.text("gap"));
  }
  sweep.expect_within(1e-12);
}

TEST(ClosedFormExtremes, Suns) {
  Sweep sweep(10, "sun that the receiver's horizon cuts, closed form", "1e-14 ... pi rad",
              "irradiance");
  const ReferenceTable table("horizon_suns");
  for (const auto& row : table.rows()) {
    Receiver receiver(1, 2, 3);
    receiver.normal = {0, 0, 1};
    const auto sun = *SunLight::create({.to_light = {row["x"], 0, row["z"]},
                                        .angular_diameter_rad = row["diameter_rad"],
                                        .illuminance_lx = Rgb(1)});
    sweep.compare(served(sun, receiver), row["irradiance_lx"],
                  row.text("diameter_rad") + " " + row.text("z"));
  }
  sweep.expect_within(1e-9);  // the same bound as above
}

}  // namespace
}  // namespace lucerna::testing
