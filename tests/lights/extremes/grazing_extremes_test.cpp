// Row 8: flat lights seen from nearly within their plane, and from within it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {
namespace {

constexpr AreaSampling kWays[] = {AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle,
                                  AreaSampling::kAutomatic, AreaSampling::kSquareRoot};

TriangleMeshLight<Served> triangle_in(const ReferenceTable::Row& row) {
  return triangle_light({vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01")});
}
PatchMeshLight<Served> rectangle_in(const ReferenceTable::Row& row) {
  return patch_light(
      {vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01"), vector_in(row, "p11")});
}

/// The cosine at the light by a normal and a way in float, cut off at 1e-4 as some do.
float textbook_cosine(const ReferenceTable::Row& row) {
  const Vec3<float> a(vector_in(row, "p00")), b(vector_in(row, "p10")), c(vector_in(row, "p01"));
  const Vec3<float> w = normalized(Vec3<float>(vector_in(row, "receiver")) - a);
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
    const Vec3<double> w = vector_in(row, "p00") - vector_in(row, "receiver");
    const double truth = row["height_m"] * (row.text("name") == "tilted" ? 3 : 1) / length(w);
    sweep.compare_textbook(textbook_cosine(row), truth);
  }
}

TEST(GrazingExtremes, TrianglesBySolidAngle) {
  Sweep sweep(8, "triangle seen from nearly within its plane, by solid angle",
              "cosine 1e-3 ... 1e-20, along axes and tilted", "irradiance");
  sweep_triangles(AreaSampling::kSolidAngle, By::kShare, By::kRoot, sweep);
  sweep_triangles(AreaSampling::kCosineSolidAngle, By::kShare, By::kRoot, sweep);
  sweep.expect_within(1e-11);
}

TEST(GrazingExtremes, TrianglesByArea) {
  Sweep sweep(8, "triangle seen from nearly within its plane, by area",
              "cosine 1e-3 ... 1e-20, along axes and tilted", "irradiance");
  sweep_triangles(AreaSampling::kSquareRoot, By::kRoot, By::kShare, sweep);
  sweep.expect_within(1e-11);
}

TEST(GrazingExtremes, Rectangles) {
  Sweep sweep(8, "rectangle seen from nearly within its plane",
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

TEST(GrazingExtremes, FromWithinThePlaneThereIsNone) {
  Sweep sweep(8, "triangle, rectangle, disk seen from within their plane", "cosine 0", "answer");
  const ReferenceTable table("grazing_polygons");
  const auto& row = table.rows().front();
  DiskParams params;
  params.world_from_object = Transform::translate({3, 0, 0});
  const auto disk =
      *DiskLight<Served>::create({Rgb<double>(1), true}, *Disk<Served>::create(params));
  const auto triangle = triangle_in(row);
  const auto rectangle = rectangle_in(row);
  for (const AreaSampling way : kWays) {
    Receiver<Served> receiver(0, 0, 0);
    receiver.normal = {1, 0, 0};
    receiver.area_sampling = way;
    const auto ask = [&](const auto& light) {
      for (const double x : {0.0, 0.25, 0.9375, 1.0})
        for (const double y : {0.0, 0.5, 1.0}) {
          const auto s = light.sample_li(receiver, {x, y});
          EXPECT_TRUE(s.value.is_black());
          EXPECT_TRUE(s.pdf.per_sr > 0 && std::isfinite(s.pdf.per_sr));
          EXPECT_EQ(light.pdf_li(receiver, s.wi).per_sr, 0);
          sweep.answer(s.reason);
        }
    };
    ask(triangle);
    ask(rectangle);
    ask(disk);
  }
  sweep.expect_answers(NoLight::kBehind);
}

TEST(GrazingExtremes, SpheresByAreaUpToTheirRim) {
  // Points by area come as near to the rim as they like, where the cosine is 0.
  Sweep sweep(8, "sphere sampled by area, up to its rim", "radius / distance 0.9 ... 1e-9",
              "irradiance");
  for (const double share : {0.9, 0.5, 1e-1, 1e-3, 1e-6, 1e-9}) {
    SphereParams params;
    params.radius_m = share;
    const auto light =
        *SphereLight<Served>::create({Rgb<double>(1)}, *Sphere<Served>::create(params));
    Receiver<Served> receiver(0, 0, 1);
    receiver.normal = {0, 0, -1};
    receiver.area_sampling = AreaSampling::kLowDistortion;
    // u.x is the share of z, which the rim is at radius^2 / distance.
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
