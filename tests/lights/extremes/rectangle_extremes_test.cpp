// Rows 5 and 6: rectangles and other quadrilaterals that are small, or that are seen from nearly
// within their plane.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/lights/extremes/area_extremes.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

AreaLight light_in(const ReferenceTable::Row& row) {
  return patch_light(
      {vector_in(row, "p00"), vector_in(row, "p10"), vector_in(row, "p01"), vector_in(row, "p11")});
}

std::string place(const ReferenceTable::Row& row) {
  return row.text("name") + ", " + row.text("solid_angle_sr") + " sr";
}

/// The sum of the angles minus two pi.  The angles come from cosines between neighbouring planes.
/// [Urena13]
float textbook_solid_angle(const ReferenceTable::Row& row) {
  const Vec3f r(vector_in(row, "receiver"));
  Vec3f corner[4], plane[4];
  const char* around[] = {"p00", "p10", "p11", "p01"};
  for (int i = 0; i < 4; ++i) corner[i] = Vec3f(vector_in(row, around[i])) - r;
  for (int i = 0; i < 4; ++i) plane[i] = normalized(cross(corner[i], corner[(i + 1) % 4]));
  float sum = -2 * std::numbers::pi_v<float>;
  for (int i = 0; i < 4; ++i) sum += std::acos(-dot(plane[i], plane[(i + 1) % 4]));
  return sum;
}

constexpr AreaSampling kWays[] = {AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle,
                                  AreaSampling::kAutomatic, AreaSampling::kLowDistortion};

/// Compares a sum over the samples of each small rectangle with a column of the table.
void sweep_small(Sweep& sweep, double Seen::*sum, const std::string& truth) {
  const ReferenceTable table("small_rectangles");
  for (const auto& row : table.rows()) {
    for (const AreaSampling way : kWays) {
      const Seen seen = seen_by<16>(light_in(row), receiver_in(row, way));
      EXPECT_EQ(seen.disagreement, 0) << place(row);
      sweep.compare(seen.*sum, row[truth], place(row));
    }
    const float solid_angle = textbook_solid_angle(row);
    if (sum == &Seen::solid_angle_sr)
      sweep.compare_textbook(solid_angle, row[truth]);
    else if (row["solid_angle_sr"] < 1e-5)
      sweep.compare_textbook(textbook_irradiance(solid_angle, row), row[truth]);
  }
  sweep.expect_within(1e-13);
}

TEST(RectangleExtremes, SolidAngleOfSmallRectangles) {
  Sweep sweep(6, "rectangle of small solid angle, sides 1 : 1 and 1 : 1024", "1e-38 ... 1e-2 sr",
              "mean of 1 / density");
  sweep_small(sweep, &Seen::solid_angle_sr, "solid_angle_sr");
}

TEST(RectangleExtremes, IrradianceOfSmallRectangles) {
  Sweep sweep(6, "rectangle of small solid angle, sides 1 : 1 and 1 : 1024", "1e-38 ... 1e-2 sr",
              "irradiance");
  sweep_small(sweep, &Seen::irradiance_lx, "irradiance_lx");
}

TEST(RectangleExtremes, SmallQuadrilaterals) {
  Sweep sweep(6, "flat bilinear patch of small solid angle that is not a rectangle",
              "1e-36 ... 1e-1 sr", "irradiance");
  const ReferenceTable table("small_quadrilaterals");
  for (const auto& row : table.rows()) {
    const Seen seen = seen_by(light_in(row), receiver_in(row, AreaSampling::kAutomatic));
    EXPECT_EQ(seen.disagreement, 0) << place(row);
    EXPECT_LE(relative_error(seen.solid_angle_sr, row["solid_angle_sr"]), 1e-12) << place(row);
    sweep.compare(seen.irradiance_lx, row["irradiance_lx"], place(row));
    if (row["solid_angle_sr"] < 1e-5)
      sweep.compare_textbook(textbook_irradiance(textbook_solid_angle(row), row),
                             row["irradiance_lx"]);
  }
  sweep.expect_within(1e-12);
}

/// The expected count of samples in each of n x n cells of the rectangle: the integral over the
/// cell of the reported density of points.
template <typename Light>
std::vector<double> expected_counts(const Light& light, const Receiver& receiver,
                                    const Vec3& corner, const Vec3& x, const Vec3& y, int n,
                                    double samples) {
  const Gauss<6>& rule = gauss<6>();
  const Vec3 area = cross(x, y);
  const Vec3 normal = normalized(area);
  const double height = std::fabs(dot(corner - receiver.position, normal));
  std::vector<double> expected(n * n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (std::size_t k = 0; k < 6; ++k)
        for (std::size_t l = 0; l < 6; ++l) {
          const Vec3 p = corner + x * ((i + rule.node[k]) / n) + y * ((j + rule.node[l]) / n);
          const double d = length(p - receiver.position);
          const double sr = height / d / d / d * length(area) / (n * n);
          expected[i * n + j] += samples * rule.weight[k] * rule.weight[l] * sr *
                                 light.pdf_li(receiver, SurfacePoint{p, normal, 0}).per_sr;
        }
  return expected;
}

TEST(RectangleExtremes, SamplesOfEdgeOnRectanglesFollowTheirDensity) {
  Sweep sweep(5, "rectangle of small solid angle, receiver nearly in its plane",
              "1e-8 ... 3e-3 sr, on both sides of the threshold",
              "chi-square test of 40000 samples against the reported density");
  const ReferenceTable table("edge_on_rectangles");
  for (const auto& row : table.rows()) {
    const auto light = light_in(row);
    const Vec3 corner = vector_in(row, "p00"), x = vector_in(row, "p10") - corner,
               y = vector_in(row, "p01") - corner;
    for (const AreaSampling way : kWays) {
      const Receiver receiver = receiver_in(row, way);
      constexpr int kBins = 12, kSamples = 40000;
      std::vector<double> observed(kBins * kBins);
      RandomU random(0x5e5);
      for (int i = 0; i < kSamples; ++i) {
        const auto s = light.sample_li(receiver, random.pair());
        const Vec3 p = s.point - corner;
        const auto bin = [&](const Vec3& edge) {
          return std::clamp(int(dot(p, edge) / dot(edge, edge) * kBins), 0, kBins - 1);
        };
        ++observed[bin(x) * kBins + bin(y)];
      }
      const auto expected = expected_counts(light, receiver, corner, x, y, kBins, kSamples);
      // Fails by chance once in 1e8.
      const double p = chi_square_p_value(observed, expected);
      sweep.answer(p > 1e-8 ? "passes" : "fails");
      EXPECT_GT(p, 1e-8) << place(row) << " way " << int(way);
    }
  }
  sweep.expect_answers("passes");
}

TEST(RectangleExtremes, SolidAngleAndIrradianceOfEdgeOnRectangles) {
  Sweep sweep(5, "rectangle of small solid angle, receiver nearly in its plane",
              "1e-8 ... 3e-3 sr, on both sides of the threshold", "solid angle and irradiance");
  const ReferenceTable table("edge_on_rectangles");
  for (const auto& row : table.rows()) {
    for (const AreaSampling way : {AreaSampling::kSolidAngle, AreaSampling::kCosineSolidAngle}) {
      const Seen seen = seen_by<128>(light_in(row), receiver_in(row, way));
      EXPECT_EQ(seen.disagreement, 0) << place(row);
      sweep.compare(seen.solid_angle_sr, row["solid_angle_sr"], place(row));
      sweep.compare(seen.irradiance_lx, row["irradiance_lx"], place(row));
    }
    sweep.compare_textbook(textbook_solid_angle(row), row["solid_angle_sr"]);
  }
  sweep.expect_within(1e-6);
}

}  // namespace
}  // namespace lucerna::testing
