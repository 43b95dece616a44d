// Rows 1 and 2: spheres that are far or small.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lights/light.h"
#include "tests/reference_table.h"
#include "tests/sweep.h"

namespace lucerna::testing {
namespace {

/// 1 - cos of the cone by the cosine, the way of [Pharr10, 14.6.3].
float textbook_pdf(float radius, float distance) {
  const float sin2 = radius * radius / (distance * distance);
  const float cos_max = std::sqrt(std::max(0.0F, 1 - sin2));
  return 1 / (2 * std::numbers::pi_v<float> * (1 - cos_max));
}

TEST(SphereExtremes, DensityOfFarSpheres) {
  Sweep sweep(1, "sphere light, radius / distance", "1e-12 ... 0.97", "density");
  const ReferenceTable table("sphere_cone");
  for (const auto& row : table.rows()) {
    SphereParams params;
    params.radius_m = row["radius_m"];
    const auto light =
        SphereLight<Served>::create({Rgb<double>(1)}, *Sphere<Served>::create(params));
    const Vec3<Served> receiver(0, 0, row["distance_m"]);
    const auto sample = light->sample_li(receiver, {0.5, 0.5});
    sweep.compare(static_cast<float>(sample.pdf.per_sr), row["pdf_per_sr"], row.text("radius_m"));
    sweep.compare_textbook(
        textbook_pdf(static_cast<float>(row["radius_m"]), static_cast<float>(row["distance_m"])),
        row["pdf_per_sr"]);
  }
  sweep.expect_within(1e-7);
}

}  // namespace
}  // namespace lucerna::testing
