// Row 8: flat lights seen from nearly within their plane, and from within it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {
namespace {

constexpr AreaSampling kWays[] = {AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle,
                                  AreaSampling::kAutomatic, AreaSampling::kSquareRoot};

AreaLight triangle_in(const ReferenceTable::Row& row) {
  return triangle_light({vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01")});
}
AreaLight rectangle_in(const ReferenceTable::Row& row) {
  return patch_light(
      {vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01"), vector_in(row, "p11")});
}

/// The rectangle with its second side halved.  It lies in the same plane, to the last bit.
AreaLight trapezoid_in(const ReferenceTable::Row& row) {
  const Vec3 a = vector_in(row, "p00"), b = vector_in(row, "p10"), c = vector_in(row, "p01");
  return patch_light({a, b, c, b + (c - a) * 0.5});
}

/// The cosine at the light from a normal and a direction in float.  Clamped at 1e-4, like in some
/// renderers.
float textbook_cosine(const ReferenceTable::Row& row) {
  const Vec3f a(vector_in(row, "p00")), b(vector_in(row, "p10")), c(vector_in(row, "p01"));
  const Vec3f w = normalized(Vec3f(vector_in(row, "receiver")) - a);
  const float cosine = std::fabs(dot(normalized(cross(b - a, c - a)), w));
  return cosine < 1e-4F ? 0 : cosine;
}

void sweep_triangles(AreaSampling way, By by_x, By by_y, Sweep& sweep) {
  const ReferenceTable table("grazing_polygons");
  for (const auto& row : table.rows()) {
    const std::string at = row.text("name") + " " + row.text("height_m");
    const Seen seen = seen_by(triangle_in(row), receiver_in(row, way), by_x, by_y);
    EXPECT_EQ(seen.without, 0) << at;
    EXPECT_EQ(seen.disagreement, 0) << at;
    EXPECT_LE(relative_error(seen.solid_angle_sr, row["triangle_solid_angle_sr"]), 1e-11) << at;
    sweep.compare(seen.irradiance_lx, row["triangle_irradiance_lx"], at);
    const Vec3 w = vector_in(row, "p00") - vector_in(row, "receiver");
    const double truth = row["height_m"] * (row.text("name") == "tilted" ? 3 : 1) / length(w);
    sweep.compare_textbook(textbook_cosine(row), truth);
  }
}

TEST(GrazingExtremes, TrianglesBySolidAngle) {
  Sweep sweep(8, "triangle sampled by solid angle, receiver nearly in its plane",
              "cosine 1e-3 ... 1e-20, along axes and tilted", "irradiance");
  sweep_triangles(AreaSampling::kSolidAngle, By::kShare, By::kRoot, sweep);
  sweep_triangles(AreaSampling::kCosineSolidAngle, By::kShare, By::kRoot, sweep);
  sweep.expect_within(1e-11);
}

TEST(GrazingExtremes, TrianglesByArea) {
  Sweep sweep(8, "triangle sampled by area, receiver nearly in its plane",
              "cosine 1e-3 ... 1e-20, along axes and tilted", "irradiance");
  sweep_triangles(AreaSampling::kSquareRoot, By::kRoot, By::kShare, sweep);
  sweep.expect_within(1e-11);
}

TEST(GrazingExtremes, Rectangles) {
  Sweep sweep(8, "rectangle, receiver nearly in its plane",
              "cosine 1e-3 ... 1e-20, along axes and tilted", "irradiance");
  const ReferenceTable table("grazing_polygons");
  for (const auto& row : table.rows()) {
    const std::string at = row.text("name") + " " + row.text("height_m");
    for (const AreaSampling way : kWays) {
      const Seen seen = seen_by(rectangle_in(row), receiver_in(row, way));
      EXPECT_EQ(seen.without, 0) << at;
      EXPECT_EQ(seen.disagreement, 0) << at;
      EXPECT_LE(relative_error(seen.solid_angle_sr, row["solid_angle_sr"]), 1e-8) << at;
      sweep.compare(seen.irradiance_lx, row["irradiance_lx"], at);
    }
  }
  // Above its threshold the map by solid angle has lost ten of sixteen digits.
  sweep.expect_within(1e-8);
}

TEST(GrazingExtremes, Trapezoids) {
  Sweep sweep(8, "trapezoid, receiver nearly in its plane",
              "cosine 1e-3 ... 1e-20, along axes and tilted", "density");
  const ReferenceTable table("grazing_polygons");
  for (const auto& row : table.rows()) {
    const std::string at = row.text("name") + " " + row.text("height_m");
    const auto light = trapezoid_in(row);
    const Receiver receiver = receiver_in(row, AreaSampling::kAutomatic);
    // The squares of the rows have sides of 1 m, except for one of 3 m.
    const double side = row.text("name") == "tilted" ? 3 : 1, height = row["height_m"] * side;
    for (const double x : {0.0, 0.25, 0.5, 1.0})
      for (const double y : {0.0, 0.125, 0.75, 1.0}) {
        const auto s = light.sample_li(receiver, {x, y});
        EXPECT_EQ(s.reason, NoLight::kNone) << at;
        const double d = s.distance, truth = d * d / (0.75 * side * side * height / d);
        sweep.compare(s.pdf.per_sr, truth, at);
        EXPECT_EQ(light.pdf_li(receiver, SurfacePoint{s.point, s.normal, 0}).per_sr, s.pdf.per_sr)
            << at;
        const auto f = static_cast<float>(d);
        sweep.compare_textbook(
            f * f / (0.75F * static_cast<float>(side * side) * textbook_cosine(row)), truth);
      }
  }
  sweep.expect_within(1e-11);
}

/// Samples the light from a receiver within its plane, with every sampling method.
template <typename Light>
void sample_within(const Light& light, const Vec3& position, Sweep& sweep) {
  for (const AreaSampling way : kWays)
    for (const Vec3& normal : {Vec3{1, 0, 0}, {0, 0, 1}, {}}) {
      Receiver receiver(position);
      receiver.normal = normal;
      receiver.area_sampling = way;
      for (const double x : {0.0, 0.25, 0.9375, 1.0})
        for (const double y : {0.0, 0.5, 1.0}) {
          const auto s = light.sample_li(receiver, {x, y});
          EXPECT_TRUE(s.value.is_black());
          EXPECT_TRUE(s.pdf.per_sr > 0 && std::isfinite(s.pdf.per_sr));
          EXPECT_EQ(light.pdf_li(receiver, s.wi).per_sr, 0);
          sweep.answer(s.reason);
        }
    }
}

TEST(GrazingExtremes, LightsSeenFromTheirPlaneAreDark) {
  Sweep sweep(8, "triangle, rectangle, trapezoid, tilted or not, receiver in their plane",
              "cosine 0", "answer");
  const ReferenceTable table("grazing_polygons");
  for (const auto& row : table.rows()) {
    const bool tilted = row.text("name") == "tilted";
    // Some receivers lie on the extension of an edge.
    const auto receivers =
        tilted ? std::vector<Vec3>{{0, 0, 0}, {6, 6, 0}, {5, 4, -2}, {-3, -3, 0}}
               : std::vector<Vec3>{{0, 0, 0}, {5, 3, 0}, {5, -0.5, 0}, {-7, 0.125, 0}};
    for (const Vec3& receiver : receivers) {
      sample_within(triangle_in(row), receiver, sweep);
      sample_within(rectangle_in(row), receiver, sweep);
      sample_within(trapezoid_in(row), receiver, sweep);
    }
  }
  // In the plane of (1, 2, 2) and (2, 1, -2), far from the origin.
  for (const Vec3& receiver : {Vec3{33, 6, 6}, {27, -6, -6}, {36, 3, -6}}) {
    sample_within(triangle_light({{{30, 0, 0}, {31, 2, 2}, {32, 1, -2}}}), receiver, sweep);
    sample_within(patch_light({{{30, 0, 0}, {31, 2, 2}, {32, 1, -2}, {33, 3, 0}}}), receiver,
                  sweep);
    sample_within(patch_light({{{30, 0, 0}, {32, 4, 4}, {32, 1, -2}, {33, 3, 0}}}), receiver,
                  sweep);
  }
  sweep.expect_answers(NoLight::kBehind);
}

TEST(GrazingExtremes, DisksSeenFromTheirPlaneAreDark) {
  Sweep sweep(8, "disk, tilted or not, receiver in its plane", "cosine 0", "answer");
  const auto tilted = *Transform::from_matrix({{{1, 2, 2, 30}, {2, 1, -2, 0}, {2, -2, 1, 0}}});
  for (const auto& [at, receivers] :
       {std::pair{Transform::translate({3, 0, 0}),
                  std::vector<Vec3>{{0, 0, 0}, {5, 7, 0}, {-1e6, 1, 0}}},
        std::pair{tilted, std::vector<Vec3>{{33, 6, 6}, {27, -6, -6}, {36, 3, -6}}}}) {
    const auto disk = *AreaLight::create({Rgb(1), true}, *Disk::create({.world_from_object = at}));
    for (const Vec3& receiver : receivers) sample_within(disk, receiver, sweep);
  }
  sweep.expect_answers(NoLight::kBehind);
}

TEST(GrazingExtremes, PointsSeenFromTheirTangentPlaneAreDark) {
  Sweep sweep(8, "sphere or cylinder sampled by area, receiver in the tangent plane of the point",
              "cosine 0", "answer");
  const auto there = Transform::translate({1, 2, 3});
  const auto sphere = *AreaLight::create(
      {Rgb(1), true}, *Sphere::create({.radius_m = 3, .world_from_object = there}));
  const auto tube = *AreaLight::create(
      {Rgb(1), true}, *Cylinder::create({.radius_m = 3, .world_from_object = there}));
  const auto sample = [&](const auto& light, const Vec3& at, const Vec3& position, Vec2 u) {
    Receiver receiver(position);
    receiver.area_sampling = AreaSampling::kSquareRoot;
    const auto s = light.sample_li(receiver, u);
    EXPECT_LE(length(s.point - at), 1e-15);
    EXPECT_TRUE(s.value.is_black());
    EXPECT_TRUE(s.pdf.per_sr > 0 && std::isfinite(s.pdf.per_sr));
    EXPECT_EQ(light.pdf_li(receiver, SurfacePoint{s.point, s.normal, 0}).per_sr, 0);
    sweep.answer(s.reason);
  };
  for (const Vec2& off : {Vec2{1, 0}, {0, -2}, {3, 4}, {-5, 12}, {1e6, 7}, {0x1p-20, 0x1p-30}}) {
    // The top of the sphere, and the line of the cylinder where its sweep begins.
    sample(sphere, {1, 2, 6}, {1 + off.x, 2 + off.y, 6}, {1, 0.25});
    sample(tube, {4, 2, 3}, {4, 2 + off.x, 3 + off.y}, {0.5, 0});
  }
  sweep.expect_answers(NoLight::kBehind);
}

TEST(GrazingExtremes, SpheresByAreaUpToTheirRim) {
  // Points by area come arbitrarily close to the rim, where the cosine is 0.
  Sweep sweep(8, "sphere sampled by area, up to its rim", "radius / distance 0.9 ... 1e-9",
              "irradiance");
  for (const double share : {0.9, 0.5, 1e-1, 1e-3, 1e-6, 1e-9}) {
    const auto light = *AreaLight::create({Rgb(1)}, *Sphere::create({.radius_m = share}));
    Receiver receiver(0, 0, 1);
    receiver.normal = {0, 0, -1};
    receiver.area_sampling = AreaSampling::kLowDistortion;
    // u.x is the share of z, and the rim is at z = radius^2 / distance.
    const double rim = (1 + share) / 2;
    const Seen seen = seen_by<64>(light, receiver, By::kShare, By::kShare, {rim, 0}, {1, 1});
    EXPECT_EQ(seen.without, 0) << share;
    EXPECT_EQ(seen.disagreement, 0) << share;
    EXPECT_EQ(light.sample_li(receiver, {rim - 1e-9, 0.5}).reason, NoLight::kBehind);
    sweep.compare(seen.irradiance_lx, std::numbers::pi * share * share, std::to_string(share));
  }
  sweep.expect_within(1e-12);
}

}  // namespace
}  // namespace lucerna::testing
