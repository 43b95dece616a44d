// Rows 3 and 4: triangles that cover almost nothing, or almost the whole hemisphere.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/lights/extremes/area_extremes.h"

namespace lucerna::testing {
namespace {

AreaLight light_in(const ReferenceTable::Row& row) {
  return triangle_light({vector_in(row, "a"), vector_in(row, "b"), vector_in(row, "c")});
}

/// The sum of the angles minus pi (Girard), each angle from the cosine between the planes of two
/// sides.
float textbook_solid_angle(const ReferenceTable::Row& row) {
  const Vec3f r(vector_in(row, "receiver"));
  const Vec3f a = normalized(Vec3f(vector_in(row, "a")) - r);
  const Vec3f b = normalized(Vec3f(vector_in(row, "b")) - r);
  const Vec3f c = normalized(Vec3f(vector_in(row, "c")) - r);
  const Vec3f ab = normalized(cross(a, b)), bc = normalized(cross(b, c)),
              ca = normalized(cross(c, a));
  return std::acos(-dot(ab, bc)) + std::acos(-dot(bc, ca)) + std::acos(-dot(ca, ab)) -
         std::numbers::pi_v<float>;
}

std::string place(const ReferenceTable::Row& row) {
  return row.text("name") + ", " + row.text("solid_angle_sr") + " sr";
}

/// Compares a sum over the samples of each small triangle with a column of the table.
void sweep_small(Sweep& sweep, double Seen::*sum, const std::string& truth) {
  const ReferenceTable table("small_triangles");
  for (const auto& row : table.rows()) {
    const auto light = light_in(row);
    for (const AreaSampling way : {AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle})
      sweep.compare(seen_by(light, receiver_in(row, way), By::kShare, By::kRoot).*sum, row[truth],
                    place(row));
    sweep.compare(seen_by(light, receiver_in(row, AreaSampling::kSquareRoot), By::kRoot).*sum,
                  row[truth], place(row));
    sweep.compare(seen_beside_diagonal(light, receiver_in(row, AreaSampling::kAutomatic)).*sum,
                  row[truth], place(row) + ", automatic");
    const float solid_angle = textbook_solid_angle(row);
    if (sum == &Seen::solid_angle_sr)
      sweep.compare_textbook(solid_angle, row[truth]);
    else if (row["solid_angle_sr"] < 1e-6)
      sweep.compare_textbook(textbook_irradiance(solid_angle, row), row[truth]);
  }
  sweep.expect_within(1e-12);
}

TEST(TriangleExtremes, SolidAngleOfSmallTriangles) {
  Sweep sweep(4, "triangle of small solid angle: frontal, oblique, and with sides 1 : 1000",
              "1e-40 ... 1e-3 sr, by solid angle, cosine, area, automatic", "mean of 1 / density");
  sweep_small(sweep, &Seen::solid_angle_sr, "solid_angle_sr");
}

TEST(TriangleExtremes, IrradianceOfSmallTriangles) {
  Sweep sweep(4, "triangle of small solid angle: frontal, oblique, and with sides 1 : 1000",
              "1e-40 ... 1e-3 sr, by solid angle, cosine, area, automatic", "irradiance");
  sweep_small(sweep, &Seen::irradiance_lx, "irradiance_lx");
}

TEST(TriangleExtremes, SamplesOfSmallTrianglesHaveTheDensityOfTheirPoints) {
  Sweep sweep(4, "triangle of small solid angle", "1e-40 ... 1e-3 sr, all ways to sample it",
              "density of a sample against the density of its point");
  const ReferenceTable table("small_triangles");
  for (const auto& row : table.rows()) {
    const auto light = light_in(row);
    for (const AreaSampling way :
         {AreaSampling::kSquareRoot, AreaSampling::kKraemer, AreaSampling::kParallelogram,
          AreaSampling::kRejection, AreaSampling::kLowDistortion, AreaSampling::kSolidAngle,
          AreaSampling::kCosineSolidAngle, AreaSampling::kAutomatic}) {
      const Seen seen = seen_by<8>(light, receiver_in(row, way));
      EXPECT_EQ(seen.without, 0) << place(row);
      sweep.compare(seen.disagreement, 0, place(row));
    }
  }
  sweep.expect_within(0);
}

TEST(TriangleExtremes, SolidAngleNearTheHemisphere) {
  Sweep sweep(3, "triangle that fills nearly the whole hemisphere, vertices up to 1e9",
              "height / size 1 ... 1e-20, above its middle, above and beside its edges",
              "mean of 1 / density");
  const ReferenceTable table("hemisphere_triangles");
  for (const auto& row : table.rows()) {
    // Without a normal, because with one the automatic method would include the cosine.
    for (const AreaSampling way : {AreaSampling::kSolidAngle, AreaSampling::kAutomatic}) {
      Receiver receiver = receiver_in(row, way);
      receiver.normal = {};
      const Seen seen = seen_by(light_in(row), receiver);
      EXPECT_EQ(seen.without, 0) << place(row);
      EXPECT_EQ(seen.disagreement, 0) << place(row);
      sweep.compare(seen.solid_angle_sr, row["solid_angle_sr"], place(row));
    }
    sweep.compare_textbook(textbook_solid_angle(row), row["solid_angle_sr"]);
  }
  sweep.expect_within(1e-13);
}

TEST(TriangleExtremes, IrradianceNearTheHemisphere) {
  Sweep sweep(3, "triangle that fills nearly the whole hemisphere, vertices up to 1e9",
              "height / size 1 ... 1e-20, by solid angle, cosine, automatic", "irradiance");
  const ReferenceTable table("hemisphere_triangles");
  for (const auto& row : table.rows()) {
    const auto light = light_in(row);
    for (const AreaSampling way :
         {AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle, AreaSampling::kAutomatic})
      sweep.compare(seen_in_halves(light, receiver_in(row, way), By::kRoot).irradiance_lx,
                    row["irradiance_lx"], place(row));
    sweep.compare_textbook(textbook_solid_angle(row) / 2, row["irradiance_lx"]);
  }
  sweep.expect_within(1e-10);
}

}  // namespace
}  // namespace lucerna::testing
