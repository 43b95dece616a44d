// Rows 10 and 29: disks of light at infinity, from the width of a ray to half of the sky.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lights/models/sun_light.h"
#include "tests/extremes_sweep.h"
#include "tests/reference_table.h"

namespace lucerna::testing {
namespace {

constexpr SceneSphere kScene{{0, 0, 0}, 2};
const char* const kDiameters = "1e-15 ... 180 degrees";

SunLight sun(const ReferenceTable::Row& row) {
  return *SunLight::create({.to_light = {1, -2, 3},
                            .angular_diameter_rad = row["diameter_rad"],
                            .illuminance_lx = Rgb(100)});
}

TEST(SunExtremes, Radiance) {
  Sweep sweep(10, "sun, angular diameter", kDiameters, "radiance");
  const ReferenceTable table("suns");
  for (const auto& row : table.rows()) {
    const auto light = sun(row);
    for (const double u : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      const auto sample = light.sample_li({0, 0, 0}, {u, u});
      sweep.compare(sample.value.g, row["radiance"], row.text("diameter_deg"));
      sweep.compare(light.le_escaped({}, sample.wi).g, row["radiance"], row.text("diameter_deg"));
    }
    // The formula for cones: a uniform radiance over the solid angle.
    const float cos = std::cos(static_cast<float>(row["diameter_rad"] / 2));
    sweep.compare_textbook(100 / (std::numbers::pi_v<float> * (1 - cos * cos)), row["radiance"]);
  }
  sweep.expect_within(1e-15);
}

TEST(SunExtremes, Density) {
  Sweep sweep(10, "sun, angular diameter", kDiameters, "density of sampled directions");
  const ReferenceTable table("suns");
  for (const auto& row : table.rows()) {
    const auto light = sun(row);
    for (const double u : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      const auto sample = light.sample_li({0, 0, 0}, {u, u});
      sweep.compare(sample.pdf.per_sr, row["per_sr"], row.text("diameter_deg"));
      sweep.compare(light.pdf_li({0, 0, 0}, sample.wi).per_sr, row["per_sr"],
                    row.text("diameter_deg"));
    }
    const float cos = std::cos(static_cast<float>(row["diameter_rad"] / 2));
    sweep.compare_textbook(1 / (2 * std::numbers::pi_v<float> * (1 - cos)), row["per_sr"]);
  }
  sweep.expect_within(1e-15);
}

/// Expects no density beyond the rim, as accurately as doubles resolve directions there.
TEST(SunExtremes, Rim) {
  Sweep sweep(10, "sun, angular diameter", "1e-8 ... 180 degrees",
              "density at a thousandth inside and outside the rim");
  const ReferenceTable table("suns");
  const Frame frame = Frame::around(normalized(Vec3{1, -2, 3}));
  for (const auto& row : table.rows()) {
    const double half = row["diameter_rad"] / 2;
    if (half < 8e-11) continue;
    const auto light = sun(row);
    for (int i = 0; i < 12; ++i) {
      const double phi = i;
      const auto towards = [&](double angle) {
        return frame.world_from_local(
            {std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), std::cos(angle)});
      };
      const Vec3 within = towards(half * 0.999), beyond = towards(half * 1.001);
      sweep.compare(light.pdf_li({0, 0, 0}, within).per_sr, row["per_sr"],
                    row.text("diameter_deg"));
      EXPECT_EQ(light.pdf_li({0, 0, 0}, beyond).per_sr, 0) << row.text("diameter_deg");
      EXPECT_TRUE(light.le_escaped({}, beyond).is_black()) << row.text("diameter_deg");
      EXPECT_EQ(light.pdf_le(Vec3() - beyond * 2, -beyond, kScene).direction.per_sr, 0);
    }
  }
  sweep.expect_within(1e-15);
}

/// Cosines are uniform over the disk, so the midpoints of a grid have their mean.
TEST(SunExtremes, Illuminance) {
  Sweep sweep(10, "sun, angular diameter", kDiameters, "illuminance from its samples");
  const ReferenceTable table("suns");
  const Vec3 facing = normalized(Vec3{1, -2, 3});
  for (const auto& row : table.rows()) {
    const auto light = sun(row);
    double sum = 0;
    constexpr int kSide = 8;
    for (int i = 0; i < kSide * kSide; ++i) {
      const auto s =
          light.sample_li({0, 0, 0}, {(i / kSide + 0.5) / kSide, (i % kSide + 0.5) / kSide});
      sum += s.value.g * dot(facing, Vec3(s.wi)) / s.pdf.per_sr;
    }
    sweep.compare(sum / (kSide * kSide), 100, row.text("diameter_deg"));
    const float cos = std::cos(static_cast<float>(row["diameter_rad"] / 2));
    const float radiance = 100 / (std::numbers::pi_v<float> * (1 - cos * cos));
    sweep.compare_textbook(radiance * (2 * std::numbers::pi_v<float> * (1 - cos)) * (1 + cos) / 2,
                           100);
  }
  // 64 terms, each with a few roundings.
  sweep.expect_within(1e-14);
}

TEST(SunExtremes, Power) {
  Sweep sweep(29, "sun, angular diameter", kDiameters, "power");
  const ReferenceTable table("suns");
  for (const auto& row : table.rows()) {
    const auto light = sun(row);
    const Power exact = light.power(kScene), approximate = light.power_approximate(kScene);
    sweep.compare(exact.lumens.g, row["power_lm"], row.text("diameter_deg"));
    EXPECT_LE(std::fabs(approximate.lumens.g - row["power_lm"]),
              approximate.error_lumens + 1e-12 * row["power_lm"]);
    sweep.compare_textbook(100 * std::numbers::pi_v<float> * 4, row["power_lm"]);
  }
  sweep.expect_within(1e-15);
}

}  // namespace
}  // namespace lucerna::testing
