#include "lights/sampling/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <vector>

#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using testing::chi_square_p_value;
using testing::RandomU;

constexpr std::array<float, 5> kExtremes{0.F, 0x1p-24F, 0.5F, 1 - 0x1p-24F, 1.F};

/// The p-value of a chi-square test on 16 x 16 boxes: are the points `unit(u)` uniform over the
/// unit square?  `unit` inverts the warp by formulas of its own.
double p_value(const std::function<Vec2(Vec2)>& unit) {
  constexpr int kSamples = 1 << 16, kBins = 16;
  std::vector<double> observed(kBins * kBins);
  RandomU random(0x3a1);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 p = unit(random.pair());
    const int x = std::clamp(int(p.x * kBins), 0, kBins - 1);
    const int y = std::clamp(int(p.y * kBins), 0, kBins - 1);
    ++observed[x * kBins + y];
  }
  return chi_square_p_value(observed,
                            std::vector<double>(observed.size(), kSamples / double(kBins * kBins)));
}

double turn(double y, double x) {
  const double t = std::atan2(y, x) / (2 * std::numbers::pi);
  return t < 0 ? t + 1 : t;
}

// Each rejects by chance with probability 1e-8.
TEST(Sampling, SphereIsUniform) {
  EXPECT_GT(p_value([](Vec2 u) {
              const auto w = sample_uniform_sphere(u);
              return Vec2{(1.0 + w.x) / 2, turn(w.z, w.y)};  // about x, not the warp's z
            }),
            1e-8);
  EXPECT_FLOAT_EQ(uniform_sphere_pdf().per_sr * 12.5663706F, 1);
}

TEST(Sampling, ConesOfEveryWidthAreUniform) {
  for (const double h : {1e-14, 1e-6, 0.1, 1., 2.}) {
    EXPECT_GT(p_value([h](Vec2 u) {
                const auto w = sample_uniform_cone(u, h);
                // sin^2 = h (2 - h), solved for h without cancellation.
                const double sin2 = w.x * w.x + w.y * w.y;
                const double one_minus_cos = w.z > 0 ? sin2 / (1 + w.z) : 1 - w.z;
                return Vec2{one_minus_cos / h, turn(w.y, w.x)};
              }),
              1e-8)
        << h;
    EXPECT_DOUBLE_EQ(uniform_cone_pdf(h).per_sr * 2 * std::numbers::pi * h, 1);
  }
}

TEST(Sampling, DiskIsUniform) {
  EXPECT_GT(p_value([](Vec2 u) {
              const auto p = sample_concentric_disk(u);
              return Vec2{double{p.x} * p.x + double{p.y} * p.y, turn(p.y, p.x)};
            }),
            1e-8);
  EXPECT_FLOAT_EQ(concentric_disk_pdf(2.F).per_m2, 0.0795774715F);  // 1 / (4 pi)
}

TEST(Sampling, TriangleIsUniform) {
  EXPECT_GT(p_value([](Vec2 u) {
              const auto b = sample_uniform_triangle(u);
              const double rest = 1.0 - b.x;
              return Vec2{rest * rest, b.y / rest};
            }),
            1e-8);
  EXPECT_EQ(uniform_triangle_pdf(0.5).per_m2, 2);
}

TEST(Sampling, TestRejectsADiskWithoutItsSquareRootAndATriangleWithoutItsFold) {
  EXPECT_LT(p_value([](Vec2 u) { return Vec2{double{u.x} * u.x, u.y}; }), 1e-8);
  EXPECT_LT(p_value([](Vec2 u) {
              const double rest = 1.0 - u.x / 2;
              return Vec2{rest * rest, u.y * rest};
            }),
            1e-8);
}

TEST(Sampling, TheWholeClosedSquareStaysInTheDomain) {
  constexpr double kUlps = 4 * 0x1p-52;
  for (const double x : kExtremes) {
    for (const double y : kExtremes) {
      const Vec2 u{x, y};
      EXPECT_NEAR(length(sample_uniform_sphere(u)), 1, kUlps);
      for (const double h : {0., 1e-20, 1e-7, 1., 2.}) {
        const auto w = sample_uniform_cone(u, h);
        EXPECT_NEAR(length(w), 1, kUlps);
        EXPECT_GE(w.z, 1 - h - kUlps);
      }
      const auto d = sample_concentric_disk(u);
      EXPECT_LE(d.x * d.x + d.y * d.y, 1 + kUlps);
      const auto b = sample_uniform_triangle(u);
      EXPECT_GE(std::min({b.x, b.y, b.z}), 0);
      EXPECT_NEAR(b.x + b.y + b.z, 1, kUlps);
    }
  }
}

TEST(Sampling, DiskReachesItsCentreAndItsRim) {
  EXPECT_EQ(sample_concentric_disk(Vec2{0.5F, 0.5F}), Vec2());
  EXPECT_EQ(sample_concentric_disk(Vec2{1, 0.5F}), (Vec2{1, 0}));
  EXPECT_EQ(sample_concentric_disk(Vec2{0.5F, 0}), (Vec2{0, -1}));
}

TEST(Sampling, TriangleReachesItsCorners) {
  EXPECT_EQ(sample_uniform_triangle(Vec2{0, 0}), Vec3(0, 0, 1));
  EXPECT_EQ(sample_uniform_triangle(Vec2{1, 0}), Vec3(1, 0, 0));
  EXPECT_EQ(sample_uniform_triangle(Vec2{0, 1}), Vec3(0, 1, 0));
}

}  // namespace
}  // namespace lucerna
