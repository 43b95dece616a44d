// Rows 3, 6 and 8: disks and cylinders that are small, grazing, or as wide as the hemisphere.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lights/maths/vec.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {
namespace {

/// The disk of a row, seen from the origin.
AreaLight disk_in(const ReferenceTable::Row& row) {
  const auto at = Transform::translate({row["offset_m"], 0, row["height_m"]});
  return *AreaLight::create({Rgb(1), true},
                            *Disk::create({.radius_m = row["radius_m"], .world_from_object = at}));
}

Receiver at_origin(const ReferenceTable::Row& row, AreaSampling way) {
  Receiver receiver(0, 0, 0);
  receiver.normal = vector_in(row, "normal");
  receiver.area_sampling = way;
  return receiver;
}

/// Integrates over samples of a disk by solid angle.  The map has four quarters of the square, each
/// smooth.
template <std::size_t kNodes = 24, typename Light>
Seen seen_in_quarters(const Light& light, const Receiver& receiver) {
  // The quarters are those of the concentric map, cut by both diagonals.  Each triangle is
  // integrated as a square.
  const Gauss<kNodes>& rule = gauss<kNodes>();
  Seen seen;
  for (std::size_t i = 0; i < kNodes; ++i)
    for (std::size_t j = 0; j < kNodes; ++j) {
      const double a = rule.node[i], b = a * (2 * rule.node[j] - 1);
      const double weight = rule.weight[i] * rule.weight[j] * a / 2;
      for (const Vec2 p : {Vec2{a, b}, {-a, b}, {b, a}, {b, -a}})
        seen.add(light, receiver, {(1 + p.x) / 2, (1 + p.y) / 2}, weight);
    }
  return seen;
}

Seen seen_disk(const AreaLight& light, const Receiver& receiver) {
  Receiver by_area = receiver;
  by_area.area_sampling = AreaSampling::kLowDistortion;
  // Without a density by solid angle, points are sampled by area, smooth in the radius.
  const bool is_by_area =
      light.sample_li(receiver, {0.3, 0.6}).point == light.sample_li(by_area, {0.3, 0.6}).point;
  return is_by_area ? seen_by<64>(light, receiver, By::kRoot)
                    : seen_in_quarters<32>(light, receiver);
}

float textbook_disk_solid_angle(const ReferenceTable::Row& row) {
  // A cap with the area of the disk; 1 - cos as a difference.
  const float r = static_cast<float>(row["radius_m"]);
  const float d = static_cast<float>(std::hypot(row["offset_m"], row["height_m"]));
  return 2 * std::numbers::pi_v<float> * (1 - d / std::sqrt(d * d + r * r)) *
         (static_cast<float>(row["height_m"]) / d);
}

void sweep_disks(const std::string& name, Sweep& sweep) {
  const ReferenceTable table("disks");
  for (const auto& row : table.rows()) {
    if (row.text("name") != name) continue;
    const auto light = disk_in(row);
    const std::string at = row.text("radius_m") + ", " + row.text("height_m");
    for (const AreaSampling way : {AreaSampling::kSolidAngle, AreaSampling::kLowDistortion}) {
      // Almost no point by area lies where a disk that covers the hemisphere is visible.
      if (name == "low" && way != AreaSampling::kSolidAngle) continue;
      const Seen seen = seen_disk(light, at_origin(row, way));
      EXPECT_EQ(seen.without, 0) << at;
      EXPECT_EQ(seen.disagreement, 0) << at;
      sweep.compare(seen.solid_angle_sr, row["solid_angle_sr"], at);
      sweep.compare(seen.irradiance_lx, row["irradiance_lx"], at);
    }
    sweep.compare_textbook(textbook_disk_solid_angle(row), row["solid_angle_sr"]);
  }
}

TEST(DiskExtremes, SmallDisks) {
  Sweep sweep(6, "disk of small solid angle", "1e-30 ... 1e-2 sr", "solid angle and irradiance");
  sweep_disks("small", sweep);
  sweep.expect_within(1e-11);
}

TEST(DiskExtremes, GrazingDisks) {
  Sweep sweep(8, "disk, receiver nearly in its plane", "cosine 1e-3 ... 1e-20",
              "solid angle and irradiance");
  sweep_disks("grazing", sweep);
  sweep.expect_within(1e-11);
}

TEST(DiskExtremes, DisksAsWideAsTheHemisphere) {
  Sweep sweep(3, "disk that fills nearly the whole hemisphere", "height / radius 1 ... 1e-20",
              "solid angle and irradiance");
  sweep_disks("low", sweep);
  sweep.expect_within(1e-12);
}

TEST(DiskExtremes, TiltedGrazingDisks) {
  Sweep sweep(8, "disk in a tilted plane, receiver nearly in this plane", "cosine 1e-3 ... 1e-20",
              "irradiance");
  const auto at = *Transform::from_matrix({{{1, 2, 2, -3}, {2, 1, -2, -6}, {2, -2, 1, -6}}});
  const auto light = *AreaLight::create({Rgb(1), true}, *Disk::create({.world_from_object = at}));
  const ReferenceTable table("tilted_disks");
  for (const auto& row : table.rows()) {
    const Seen seen = seen_by<32>(light, receiver_in(row, AreaSampling::kLowDistortion), By::kRoot);
    EXPECT_EQ(seen.without, 0) << row.text("height");
    EXPECT_EQ(seen.disagreement, 0) << row.text("height");
    EXPECT_LE(relative_error(seen.solid_angle_sr, row["solid_angle_sr"]), 1e-11);
    sweep.compare(seen.irradiance_lx, row["irradiance_lx"], row.text("height"));
    // Normal and receiver in float: the result is the rounding of their product.
    const Vec3f n = normalized(Vec3f(2, -2, 1)), r(vector_in(row, "receiver"));
    const float height = dot(r + Vec3f(3, 6, 6), n);
    sweep.compare_textbook(height, 3 * row["height"]);
  }
  sweep.expect_within(1e-11);
}

AreaLight cylinder_in(const ReferenceTable::Row& row) {
  return *AreaLight::create({Rgb(1)}, *Cylinder::create({.radius_m = row["radius_m"],
                                                         .z_min_m = row["z_min_m"],
                                                         .z_max_m = row["z_max_m"]}));
}

void sweep_cylinders(const std::string& name, Sweep& sweep) {
  const ReferenceTable table("cylinders");
  for (const auto& row : table.rows()) {
    if (row.text("name") != name) continue;
    const auto light = cylinder_in(row);
    Receiver receiver(row["receiver_m"], 0, 0);
    receiver.normal = vector_in(row, "normal");
    // Only the part between the tangents is visible.
    const double share = row["tangent_rad"] / (2 * kPi);
    const Seen before = seen_by(light, receiver, By::kShare, By::kShare, {0, 0}, {1, share});
    const Seen after = seen_by(light, receiver, By::kShare, By::kShare, {0, 1 - share}, {1, 1});
    EXPECT_EQ(before.disagreement + after.disagreement, 0);
    EXPECT_EQ(light.sample_li(receiver, {0.5, 0.5}).reason, NoLight::kBehind);
    sweep.compare(before.irradiance_lx + after.irradiance_lx, row["irradiance_lx"],
                  row.text("radius_m") + ", " + row.text("receiver_m"));
  }
}

TEST(CylinderExtremes, SmallCylinders) {
  Sweep sweep(6, "cylinder of small solid angle", "radius / distance 0.1 ... 1e-15", "irradiance");
  sweep_cylinders("small", sweep);
  sweep.expect_within(1e-12);
}

TEST(CylinderExtremes, CylindersFromJustAboveTheirTangent) {
  Sweep sweep(8, "cylinder, receiver just above its tangent plane", "height / radius 0.1 ... 1e-9",
              "irradiance");
  sweep_cylinders("grazing", sweep);
  // Points are rounded by 2^-53 of the radius, and the height is at least 1e-9 of it.
  sweep.expect_within(0x1p-53 / 1e-9);
}

TEST(CylinderExtremes, TubesSeenAlongTheirAxis) {
  Sweep sweep(8, "inside of a cylinder seen along its axis", "cosine 0.1 ... 1e-20", "irradiance");
  const ReferenceTable table("tubes");
  for (const auto& row : table.rows()) {
    const auto light = *AreaLight::create(
        {Rgb(1), true},
        *Cylinder::create({.radius_m = row["radius_m"], .z_min_m = 1, .z_max_m = 2}));
    Receiver receiver(0, 0, 0);
    receiver.normal = {0, 0, 1};
    const Seen seen = seen_by(light, receiver);
    EXPECT_EQ(seen.without, 0) << row.text("radius_m");
    EXPECT_EQ(seen.disagreement, 0);
    EXPECT_LE(relative_error(seen.solid_angle_sr, row["solid_angle_sr"]), 1e-12);
    sweep.compare(seen.irradiance_lx, row["irradiance_lx"], row.text("radius_m"));
    const float r = static_cast<float>(row["radius_m"]);
    sweep.compare_textbook(std::numbers::pi_v<float> * (r * r / (1 + r * r) - r * r / (4 + r * r)),
                           row["irradiance_lx"]);
  }
  sweep.expect_within(1e-12);
}

}  // namespace
}  // namespace lucerna::testing
