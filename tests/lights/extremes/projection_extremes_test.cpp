// Row 20: projected pictures at their border and at the edges between texels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lights/models/projection_light.h"
#include "tests/lights/extremes/map_pictures.h"

namespace lucerna::testing {
namespace {

using Row = ReferenceTable::Row;

ProjectionLight projection(const Row& row) {
  return *ProjectionLight::create(
      {.picture = *ProjectedPicture::create({.image = grey_image(4, 3, patchy_texel),
                                             .filter = filter_of(row),
                                             .fov_rad = row["fov_rad"],
                                             .aspect = row["aspect"]}),
       .intensity_cd = Rgb(1)});
}

std::string projection_of(const Row& row) {
  return row.text("filter") + " " + row.text("fov_deg") + " (" + row.text("x") + ", " +
         row.text("y") + ")";
}

/// With the value of a texel at its corner: half a texel off.
float textbook_value(const Row& row) {
  const float shorter = std::tan(static_cast<float>(row["fov_rad"]) / 2);
  const auto aspect = static_cast<float>(row["aspect"]);
  const float s = (static_cast<float>(row["x"]) / (shorter * std::max(aspect, 1.0F)) + 1) * 2;
  const float t = (1 - static_cast<float>(row["y"]) / (shorter / std::min(aspect, 1.0F))) * 1.5F;
  const bool nearest = filter_of(row) == ImageFilter::kNearest;
  const auto at = [](int i, int j) {
    return static_cast<float>(patchy_texel(std::clamp(i, 0, 3), std::clamp(j, 0, 2)));
  };
  const int i = static_cast<int>(std::floor(nearest ? s - 0.5F : s)),
            j = static_cast<int>(std::floor(nearest ? t - 0.5F : t));
  if (nearest) return at(i, j);
  const float a = s - static_cast<float>(i), b = t - static_cast<float>(j);
  return (at(i, j) * (1 - a) + at(i + 1, j) * a) * (1 - b) +
         (at(i, j + 1) * (1 - a) + at(i + 1, j + 1) * a) * b;
}

const char* const kPlaces =
    "1e-9 from the border and texel edges; fields of view 0.01 ... 179 degrees, aspect 1/3 ... 1e3";

TEST(ProjectionExtremes, Intensity) {
  Sweep sweep(20, "projection, direction", kPlaces, "intensity");
  const ReferenceTable table("projection_maps");
  for (const auto& row : table.rows()) {
    sweep.compare(projection(row).intensity({row["x"], row["y"], 1}).g, row["value"],
                  projection_of(row));
    if (row["value"] > 0) sweep.compare_textbook(textbook_value(row), row["value"]);
  }
  sweep.expect_within(1e-12);
}

TEST(ProjectionExtremes, DensityOfRays) {
  Sweep sweep(20, "projection, direction", kPlaces, "density of rays that leave it");
  const ReferenceTable table("projection_maps");
  for (const auto& row : table.rows()) {
    if (filter_of(row) == ImageFilter::kBilinear) continue;
    const double per_sr = projection(row).pdf_le({}, {row["x"], row["y"], 1}, {}).direction.per_sr;
    // Texels below 1e-5 sr are uniform in the plane, not over the sphere.
    if (row["fov_deg"] < 1) {
      EXPECT_NEAR(per_sr, row["per_sr"], 1e-5 * row["per_sr"]);
      continue;
    }
    sweep.compare(per_sr, row["per_sr"], projection_of(row));
  }
  sweep.expect_within(1e-14);
}

TEST(ProjectionExtremes, DensityCoversTheLight) {
  Sweep sweep(20, "projection, direction", kPlaces,
              "whether the density is positive exactly where there is light");
  const ReferenceTable table("projection_maps");
  for (const auto& row : table.rows()) {
    const auto light = projection(row);
    // The place itself, and both sides of the border in its row and its column.
    const double x = row["x"], y = row["y"];
    const Vec2 half = light.params().picture->half();
    for (const double beside : {1 - 1e-15, 1.0, 1 + 1e-15})
      for (const Vec3& w :
           {Vec3{x, y, 1}, Vec3{half.x * beside, y, 1}, Vec3{-half.x * beside, y, 1},
            Vec3{x, half.y * beside, 1}, Vec3{x, -half.y * beside, 1}}) {
        const bool lit = light.intensity(w).g > 0;
        const bool covered = light.pdf_le({}, w, {}).direction.per_sr > 0;
        sweep.answer(lit == covered ? "yes"
                     : lit          ? "light without density"
                                    : "density in the dark");
      }
  }
  sweep.expect_answers("yes");
}

}  // namespace
}  // namespace lucerna::testing
