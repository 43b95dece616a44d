// Disks by solid angle, near and far, facing and grazing.
#include "lights/sampling/spherical_ellipse.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

struct Seen {
  std::string name;
  double offset, height, radius;
};

std::vector<Seen> places() {
  return {{"coaxial", 0, 2, 1},         {"aside", 1.5, 2, 1},
          {"oblique", 3, 1, 1},         {"below the rim", 1, 1, 1},
          {"close", 0.25, 0.1, 1},      {"close to the rim", 1, 0.1, 1},
          {"just beside", 1.1, 0.1, 1}, {"grazing", 4, 0.05, 1},
          {"small", 1, 2, 1e-3},        {"other units", 3e10, 1e10, 1e10}};
}

/// Harder places.
std::vector<Seen> extremes() {
  return {{"covers the sky but for 1e-4", 0, 1e-4, 1},
          {"covers the sky aside", 0.5, 1e-4, 1},
          {"at the rim", 1, 1e-6, 1},
          {"beside the rim", 1 + 1e-6, 1e-6, 1},
          {"seen from within its plane but for 1e-4", 3, 3e-4, 1},
          {"tiny", 0.5, 1, 2e-5},
          {"tiny and grazing", 1, 0.05, 1e-3}};
}

SphericalEllipse seen_from(const Seen& s) {
  const auto e = SphericalEllipse::create(s.offset, s.height, s.radius);
  EXPECT_TRUE(e) << s.name;
  return *e;
}

TEST(SphericalEllipse, CoaxialDisksAreUniform) {
  for (const double radius : {1e-3, 0.5, 1., 40.}) {
    const auto e = *SphericalEllipse::create(0, 2, radius);
    const double cosine = 2 / std::hypot(2, radius);
    const double one_minus_cos = radius * radius / (4 + radius * radius) / (1 + cosine);
    for (const Vec2 p : {Vec2{0, 0}, {0.3 * radius, 0}, {0, -0.9 * radius}})
      EXPECT_NEAR(e.pdf(p) * 2 * kPi * one_minus_cos, 1, 1e-12) << radius;
  }
}

TEST(SphericalEllipse, DensitiesVaryByLessThanAFactorOfTwo) {
  auto all = places();
  for (const Seen& s : extremes()) all.push_back(s);
  for (const Seen& s : all) {
    const auto e = seen_from(s);
    RandomU random(0x5e11);
    double sum = 0, squares = 0;
    constexpr int kSamples = 100000;
    for (int i = 0; i < kSamples; ++i) {
      const double inverse = 1 / e.pdf(e.sample(random.pair()));
      sum += inverse, squares += inverse * inverse;
    }
    EXPECT_LT(std::sqrt(squares * kSamples) / sum, std::sqrt(1.125)) << s.name;
  }
}

TEST(SphericalEllipse, TheClosedSquareStaysOnTheDisk) {
  auto all = places();
  for (const Seen& s : extremes()) all.push_back(s);
  for (const Seen& s : all) {
    const auto e = seen_from(s);
    for (const double x : {0., 0x1p-24, 0.25, 0.5, 1 - 0x1p-24, 1.})
      for (const double y : {0., 0x1p-24, 0.5, 0.75, 1 - 0x1p-24, 1.}) {
        const auto p = e.sample({x, y});
        EXPECT_LE(std::hypot(p.x, p.y), s.radius * (1 + 1e-15)) << s.name;
        EXPECT_TRUE(std::isfinite(e.pdf(p)) && e.pdf(p) > 0) << s.name;
      }
    // The edge of the square is the rim.
    const auto rim = e.sample({1, 0.375});
    EXPECT_NEAR(std::hypot(rim.x, rim.y) / s.radius, 1, 1e-6) << s.name;
  }
}

TEST(SphericalEllipse, DoesNotExistBelowTheThreshold) {
  EXPECT_FALSE(SphericalEllipse::create(3, 0, 1));      // in its plane
  EXPECT_FALSE(SphericalEllipse::create(3, 1e-7, 1));   // nearly in its plane
  EXPECT_FALSE(SphericalEllipse::create(1, 1e-12, 1));  // just over its rim
  EXPECT_FALSE(SphericalEllipse::create(1, 1, 1e-9));   // far
  EXPECT_FALSE(SphericalEllipse::create(NAN, 1, 1));
  EXPECT_FALSE(SphericalEllipse::create(1, INFINITY, 1));
  EXPECT_FALSE(SphericalEllipse::create(INFINITY, 1, 1));
}

TEST(SphericalEllipse, ScalesByPowersOfTwoWithoutChangingABit) {
  const auto e = *SphericalEllipse::create(3, 1, 1);
  for (const int k : {-900, -60, 60, 900}) {
    const auto scaled =
        SphericalEllipse::create(std::scalbn(3, k), std::scalbn(1, k), std::scalbn(1, k));
    ASSERT_TRUE(scaled) << k;
    const auto p = e.sample({0.3, 0.7}), q = scaled->sample({0.3, 0.7});
    EXPECT_EQ(std::scalbn(p.x, k), q.x);
    EXPECT_EQ(std::scalbn(p.y, k), q.y);
    EXPECT_EQ(e.pdf(p), scaled->pdf(q));
  }
}

}  // namespace
}  // namespace lucerna::testing
