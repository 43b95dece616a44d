// Rows 10 and 11: spots that are narrow, and spots with a narrow edge.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "lights/models/spot_light.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;

SpotLight spot(double cone_rad, double start_rad, const Vec3& axis = {0, 0, -1}) {
  return *SpotLight::create({.axis = axis,
                             .intensity_cd = Rgb(1),
                             .cone_half_angle_rad = cone_rad,
                             .falloff_start_rad = start_rad});
}

SpotLight cone_of(const Row& row) {
  return spot(row["cone_rad"], row["start_rad"], {row["ax"], row["ay"], row["az"]});
}

bool along_z(const Row& row) { return row["az"] == -1 && row["ax"] == 0; }

Vec3 receiver_of(const Row& row) { return {row["x"], row["y"], row["z"]}; }

/// Smoothstep of cosines, along -z.  [Pharr10, 12.1.2; Pharr23, 12.2.1]
float textbook_share(float cone_rad, float start_rad, float x, float z) {
  const float cos_cone = std::cos(cone_rad), cos_start = std::cos(start_rad);
  const float cos_theta = -z / std::sqrt(x * x + z * z);
  const float t = std::clamp((cos_theta - cos_cone) / (cos_start - cos_cone), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

/// The textbook's illuminance from intensity 1 at (x, 0, z) of the row.
float textbook_illuminance(const Row& row) {
  const auto x = static_cast<float>(row["x"]), z = static_cast<float>(row["z"]);
  return textbook_share(static_cast<float>(row["cone_rad"]), static_cast<float>(row["start_rad"]),
                        x, z) /
         (x * x + z * z);
}

/// The textbook's power of intensity 1.
float textbook_power(float cone_rad, float start_rad) {
  return 2 * std::numbers::pi_v<float> * (1 - 0.5F * (std::cos(start_rad) + std::cos(cone_rad)));
}

const char* const kAngles = "1e-15 ... 60 degrees";

TEST(SpotExtremes, IlluminanceOfNarrowCones) {
  Sweep sweep(10, "spot, half-angle", kAngles,
              "illuminance on the axis, inside the cone and in its edge");
  const ReferenceTable table("spot_cones");
  for (const auto& row : table.rows()) {
    const auto sample = cone_of(row).sample_li(receiver_of(row), {});
    sweep.compare(sample.value.g, row["value_lx"], row.text("cone_deg") + " " + row.text("x"));
    if (along_z(row)) sweep.compare_textbook(textbook_illuminance(row), row["value_lx"]);
  }
  sweep.expect_within(1e-12);
}

TEST(SpotExtremes, DensityOfRaysFromNarrowCones) {
  Sweep sweep(10, "spot, half-angle", kAngles, "density of rays that leave it");
  const ReferenceTable table("spot_cones");
  for (const auto& row : table.rows()) {
    const auto pdf = cone_of(row).pdf_le({}, receiver_of(row), {});
    sweep.compare(pdf.direction.per_sr, row["per_sr"], row.text("cone_deg") + " " + row.text("x"));
    if (!along_z(row)) continue;
    const auto cone = static_cast<float>(row["cone_rad"]),
               start = static_cast<float>(row["start_rad"]);
    sweep.compare_textbook(
        textbook_share(cone, start, static_cast<float>(row["x"]), static_cast<float>(row["z"])) /
            textbook_power(cone, start),
        row["per_sr"]);
  }
  sweep.expect_within(1e-12);
}

TEST(SpotExtremes, PowerOfNarrowCones) {
  Sweep sweep(10, "spot, half-angle", kAngles, "power");
  const ReferenceTable table("spot_cones");
  for (const auto& row : table.rows()) {
    sweep.compare(cone_of(row).power({}).lumens.g, row["power_lm"], row.text("cone_deg"));
    sweep.compare_textbook(
        textbook_power(static_cast<float>(row["cone_rad"]), static_cast<float>(row["start_rad"])),
        row["power_lm"]);
  }
  sweep.expect_within(1e-15);
}

/// The angle between unit vectors, accurate for small and wide angles.
double angle_from(const Vec3& a, const Vec3& b) {
  return 2 * std::atan2(length(a - b), length(a + b));
}

/// Each ray carries the spot's power.  The share of light nearer to the axis than the ray equals
/// its sample value.
TEST(SpotExtremes, RaysOfNarrowCones) {
  Sweep sweep(10, "spot, half-angle", "1e-15 ... 179.9 degrees",
              "value over density of the rays that leave it; their angle to the axis");
  const ReferenceTable table("spot_rays");
  for (const auto& row : table.rows()) {
    const auto light = cone_of(row);
    const Vec3 axis = normalized(light.params().axis);
    Vec3 around;
    for (const double turn : {0.05, 0.3, 0.55, 0.8}) {
      const auto ray = light.sample_le({}, {row["u"], turn}, {});
      const std::string at = row.text("cone_deg") + " " + row.text("u");
      sweep.compare(ray.value.g / ray.pdf_direction.per_sr, row["power_lm"], at);
      const double angle = angle_from(ray.direction, axis);
      // The narrowest angles exist only along z; along other axes, those that unit vectors resolve.
      if (along_z(row)) sweep.compare(angle, row["angle_rad"], at);
      EXPECT_NEAR(angle, row["angle_rad"], 0x1p-51 + 1e-14 * row["angle_rad"]) << at;
      around += ray.direction - axis * dot(axis, ray.direction);
    }
    // A quarter turn has no component aside.
    EXPECT_LE(length(around), 0x1p-48 + 1e-14 * row["angle_rad"]) << row.text("cone_deg");
  }
  sweep.expect_within(1e-14);
}

TEST(SpotExtremes, NarrowEdges) {
  Sweep sweep(11, "spot, difference of inner and outer angle",
              "1e-8 ... 1e-2 rad, cones of 0.5 ... 179.9 degrees", "illuminance in the edge");
  const ReferenceTable table("spot_edges");
  // The coordinates of a receiver and of a unit vector give an angle to four roundings.  Relative
  // to the edge's width, that is the error of the place in the edge.  A quarter of the way in, x =
  // 1/4, smoothstep amplifies it by 6 (1 - x) / (x (3 - 2 x)) = 7.2.
  const auto bound = [](double delta) { return 1e-14 + 7.2 * 4 * 0x1p-53 / delta; };
  double narrowest = 1;
  for (const auto& row : table.rows()) {
    const double delta = row["delta_rad"];
    const auto sample =
        spot(row["cone_rad"], row["start_rad"]).sample_li({row["x"], 0, row["z"]}, {});
    const std::string at =
        row.text("delta_rad") + " of " + row.text("cone_rad") + " " + row.text("part");
    sweep.compare(sample.value.g, row["value_lx"], at);
    EXPECT_LE(relative_error(sample.value.g, row["value_lx"]), bound(delta)) << at;
    narrowest = std::min(narrowest, delta);
    sweep.compare_textbook(textbook_illuminance(row), row["value_lx"]);
  }
  sweep.expect_within(bound(narrowest));
}

TEST(SpotExtremes, PowerWithTheNarrowestEdgesAndHardEdges) {
  Sweep sweep(11, "spot, difference of inner and outer angle", "0, 1 ulp ... 1e-10 of the angle",
              "power");
  const ReferenceTable table("spot_narrowest_edges");
  for (const auto& row : table.rows()) {
    const double cone = row["cone_rad"], start = row["start_rad"];
    sweep.compare(spot(cone, start).power({}).lumens.g, row["power_lm"],
                  row.text("cone_rad") + " from " + row.text("start_rad"));
    sweep.compare_textbook(textbook_power(static_cast<float>(cone), static_cast<float>(start)),
                           row["power_lm"]);
  }
  sweep.expect_within(1e-15);
}

/// A hard edge is full on the axis and within the cone, and dark beyond it, with nothing in
/// between.
TEST(SpotExtremes, HardEdges) {
  Sweep sweep(11, "spot, difference of inner and outer angle", "0, 1 ulp ... 1e-10 of the angle",
              "light on the axis, half way to the edge, just inside and just outside the edge");
  const ReferenceTable table("spot_narrowest_edges");
  for (const auto& row : table.rows()) {
    const double cone = row["cone_rad"];
    const auto light = spot(cone, row["start_rad"]);
    const auto at = [&](double angle) {
      const auto s = light.sample_li({std::sin(angle), 0, -std::cos(angle)}, {});
      if (s.reason == NoLight::kOutsideCone) return std::string("dark");
      return std::string(std::fabs(s.value.g - 1) < 1e-15 ? "full" : "neither");
    };
    const bool everywhere = cone >= std::numbers::pi;
    sweep.answer(at(0) + ", " + at(cone * 0.5) + ", " + at(cone * (1 - 1e-9)) + ", " +
                 (everywhere ? "dark" : at(cone * (1 + 1e-9))));
    const float cos_cone = std::cos(static_cast<float>(cone));
    const float delta = std::cos(static_cast<float>(row["start_rad"])) - cos_cone;
    if (delta == 0)
      sweep.textbook_answer(std::isfinite((1 - cos_cone) / delta) ? "a slope"
                                                                  : "an infinite slope");
  }
  sweep.expect_answers("full, full, full, dark");
}

/// Directions around the back of the light.  They are dark up to the edge.  A soft edge that ends
/// in a point is no darker there than its share.
TEST(SpotExtremes, WidestCones) {
  Sweep sweep(12, "spot with a half-angle just below 180 degrees, receiver nearly behind it",
              "0, 1e-12 ... 0.01 rad below 180 degrees, edges of 0 ... 180 degrees; receiver 1e-15 "
              "... 0.1 rad off",
              "illuminance");
  const ReferenceTable table("spot_backs");
  for (const auto& row : table.rows()) {
    const auto sample = cone_of(row).sample_li(receiver_of(row), {});
    const std::string at = row.text("dark_rad") + " from " + row.text("start_rad") + ", " +
                           row.text("behind_rad") + " behind " + row.text("ax");
    sweep.compare(sample.value.g, row["value_lx"], at);
    EXPECT_EQ(sample.reason, row["value_lx"] > 0 ? NoLight::kNone : NoLight::kOutsideCone) << at;
    if (along_z(row)) sweep.compare_textbook(textbook_illuminance(row), row["value_lx"]);
  }
  // Unit vectors, which the test uses from a milliradian on, are accurate to 1e-13.  A hundredth of
  // the way into the edge that is 1e-11 of the place, and twice that of the light.
  sweep.expect_within(2e-11);
}

TEST(SpotExtremes, InvalidAngles) {
  Sweep sweep(12, "spot, half-angle", "0, below 0, above 180 degrees, not a number", "answer");
  constexpr double kPi = std::numbers::pi;
  for (const double cone :
       {0.0, -0.0, -1e-300, -1.0, std::nextafter(kPi, 4), 4.0, 1e30,
        std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    const auto made = SpotLight::create({.cone_half_angle_rad = cone});
    const std::string error(made.status().message());
    sweep.answer(error.starts_with("spot.cone_half_angle = ") && error.ends_with("allowed (0, pi]")
                     ? "refused; the error names the domain"
                     : "taken or refused otherwise: " + error);
  }
  for (const double cone : {5e-324, 1e-30, kPi / 2, 2 * kPi / 3, kPi})
    EXPECT_TRUE(SpotLight::create({.cone_half_angle_rad = cone}).ok()) << cone;
  sweep.expect_answers("refused; the error names the domain");
}

}  // namespace
}  // namespace lucerna::testing
