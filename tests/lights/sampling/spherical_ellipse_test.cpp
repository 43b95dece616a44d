// Disks by solid angle: samples follow their density, near and far, facing and grazing.
#include "lights/sampling/spherical_ellipse.h"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "lights/sampling/sampling.h"
#include "lights/sampling/spherical_triangle.h"
#include "tests/lights/area_helpers.h"

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

/// Harder places, where a quadrature on a grid is not accurate.
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

/// By the triangles of an inscribed polygon, [Oosterom83].  Its corners are denser the nearer they
/// are to the receiver: by a share of 1e-3 of the angle from the nearest point.
double solid_angle(const Seen& s) {
  const Vec3 middle{s.offset, 0, s.height};
  const auto rim = [&](double t) { return middle + Vec3{-std::cos(t), std::sin(t), 0} * s.radius; };
  double sum = 0;
  for (double t = 1e-10, before = 0; before < kPi; before = t, t = std::fmin(1.001 * t, kPi))
    sum += 2 * triangle_solid_angle(middle, rim(before) - middle, rim(t) - middle);
  return sum;
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

TEST(SphericalEllipse, InverseDensitiesAverageToTheSolidAngle) {
  // E[1 / p] over samples is the solid angle that the density covers.
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
    const double mean = sum / kSamples;
    const double error = std::sqrt(std::fmax(0, squares / kSamples - mean * mean) / kSamples);
    // Exceeds 6 standard errors once in 5e8; the polygon is accurate to 1e-6.
    EXPECT_NEAR(mean / solid_angle(s), 1, 6 * error / mean + 2e-6) << s.name;
    // Nearly uniform: by less than a factor of 2.
    EXPECT_LT(std::sqrt(squares / kSamples) / mean, std::sqrt(1.125)) << s.name;
  }
}

/// The p-value of the places that `sample` returns, if they follow `pdf`.
double p_value(const Seen& s, const std::function<Vec2(Vec2)>& sample) {
  const auto e = seen_from(s);
  // Rings and sectors about the point nearest to the receiver's foot would fit it best.  These are
  // about the centre, with cells fine enough for the nearest place here.
  constexpr int kBins = 16, kSub = 40, kSamples = 100000;
  std::vector<double> observed(kBins * kBins), expected(kBins * kBins);
  RandomU random(0x5e12);
  const auto bin = [](double x) { return std::clamp(int(x * kBins), 0, kBins - 1); };
  for (int i = 0; i < kSamples; ++i) {
    const auto p = sample(random.pair());
    const double phi = std::atan2(p.y, p.x) / (2 * kPi);
    ++observed[bin((p.x * p.x + p.y * p.y) / (s.radius * s.radius)) * kBins +
               bin(phi < 0 ? phi + 1 : phi)];
  }
  constexpr int kFine = kBins * kSub;
  for (int i = 0; i < kFine; ++i)
    for (int j = 0; j < kFine; ++j) {
      const double r = s.radius * std::sqrt((i + 0.5) / kFine);
      const double phi = 2 * kPi * (j + 0.5) / kFine;
      const Vec2 p{r * std::cos(phi), r * std::sin(phi)};
      const Vec3 to_point{s.offset + p.x, p.y, s.height};
      const double d = length(to_point);
      const double sr =
          kPi * s.radius * s.radius / (double(kFine) * kFine) * (s.height / d) / d / d;
      expected[(i / kSub) * kBins + j / kSub] += kSamples * e.pdf(p) * sr;
    }
  double total = 0;
  for (const double v : expected) total += v;
  EXPECT_NEAR(total / kSamples, 1, 2e-4) << s.name;
  return chi_square_p_value(observed, expected);
}

TEST(SphericalEllipse, SamplesFollowTheDensityWhichIntegratesToOne) {
  for (const Seen& s : places()) {
    const auto e = seen_from(s);
    EXPECT_GT(p_value(s, [&](Vec2 u) { return e.sample(u); }), kUnlikely) << s.name;
  }
}

TEST(SphericalEllipse, ChiSquareRejectsSamplesByAreaAndMeridiansUniformInAzimuth) {
  const Seen s = places()[2];
  EXPECT_LT(p_value(s, [](Vec2 u) { return sample_concentric_disk(u); }), kUnlikely);
  // The mistake of a circle's formula: it shrinks the disk of the middle's cone.
  const auto circle = *SphericalEllipse::create(0, std::hypot(s.offset, s.height), s.radius);
  EXPECT_LT(p_value(s, [&](Vec2 u) { return circle.sample(u); }), kUnlikely);
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
