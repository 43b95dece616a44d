// Points of flat and spherical triangles and rectangles: uniform, invertible, correct for extreme
// inputs.
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "lights/sampling/sampling.h"
#include "lights/sampling/spherical_rectangle.h"
#include "lights/sampling/spherical_triangle.h"
#include "tests/lights/area_helpers.h"

namespace lucerna::testing {
namespace {

constexpr AreaSampling kByArea[] = {AreaSampling::kSquareRoot, AreaSampling::kKraemer,
                                    AreaSampling::kParallelogram, AreaSampling::kRejection,
                                    AreaSampling::kLowDistortion};

/// The p-value of the barycentric coordinates, if they are uniform by area.
double p_value(const std::function<Vec3(Vec2)>& barycentric) {
  RandomU random(0x71);
  return uniformity_p_value([&] {
    const Vec3 b = barycentric(random.pair());
    // Maps equal areas to equal areas of the square.  x is the share on one side of the line
    // through the point parallel to an edge, y the place along that line.
    return Vec2{1 - (1 - b.x) * (1 - b.x), b.y / (1 - b.x)};
  });
}

TEST(TriangleSampling, AllFiveMapsAreUniformByArea) {
  for (const AreaSampling way : kByArea)
    EXPECT_GT(p_value([way](Vec2 u) { return sample_triangle(way, u); }), kUnlikely) << int(way);
}

TEST(TriangleSampling, TheTextbookMistakesAreRejected) {
  // Two coordinates, the second scaled to the rest: dense towards a corner.
  EXPECT_LT(p_value([](Vec2 u) {
              return Vec3{u.x, u.y * (1 - u.x), (1 - u.x) * (1 - u.y)};
            }),
            kUnlikely);
  // Three uniform numbers divided by their sum: dense towards the middle.
  RandomU third(0x72);
  EXPECT_LT(p_value([&](Vec2 u) {
              const double w = third.next() + 1e-9;
              const double sum = u.x + u.y + w;
              return Vec3{u.x / sum, u.y / sum, w / sum};
            }),
            kUnlikely);
}

TEST(TriangleSampling, TheClosedSquareStaysInTheTriangle) {
  for (const AreaSampling way : kByArea)
    for (const double x : {0., 0x1p-24, 0.5, 1 - 0x1p-24, 1.})
      for (const double y : {0., 0x1p-24, 0.5, 1 - 0x1p-24, 1.}) {
        const Vec3 b = sample_triangle(way, {x, y});
        EXPECT_GE(std::fmin(b.x, std::fmin(b.y, b.z)), 0) << int(way) << " " << x << " " << y;
        EXPECT_NEAR(b.x + b.y + b.z, 1, 1e-15);
      }
}

struct Corners {
  std::string name;
  Vec3 a, b, c;
};

/// An octant; slim and skewed ones; tiny ones at a distance and in a grazing plane; one that nearly
/// covers the hemisphere; corners at 1e9.
std::vector<Corners> triangles() {
  std::vector<Corners> t{{"octant", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                         {"skewed", {3, 1, 2}, {-1, 4, 2}, {-2, -1, 2}},
                         {"slim", {-5, 1, 2}, {5, 1, 2}, {0, 1.01, 2}},
                         {"close", {-1, -1, 1e-3}, {2, -1, 1e-3}, {-1, 2, 1e-3}},
                         {"wide", {-1e5, -1e5, 1}, {2e5, -1e5, 1}, {-1e5, 2e5, 1}},
                         {"far corner", {-1, -1, 1}, {2, -1, 1}, {1e9, 1e9, 1}},
                         {"grazing", {1, 0, 1e-6}, {2, 0, 1e-6}, {1, 1, 1e-6}}};
  for (const double size : {1e-2, 1e-4, 1e-6, 1e-12})
    t.push_back({"tiny " + std::to_string(size),
                 {0.25, 1, 2},
                 {0.25 + size, 1, 2 + size / 4},
                 {0.25, 1 + size, 2}});
  return t;
}

// (1 - cos, turn) of directions would need a region for each triangle.  Instead, the triangle is
// cut into parts that each hold their share of the solid angle.  The share comes from an
// independent formula: l'Huilier's in long double, or for small parts its planar limit.
long double reference_solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  struct V {
    long double x, y, z;
  };
  const auto v = [](const Vec3& p) { return V{p.x, p.y, p.z}; };
  const auto minus = [](V p, V q) { return V{p.x - q.x, p.y - q.y, p.z - q.z}; };
  const auto cross_of = [](V p, V q) {
    return V{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  };
  const auto dot_of = [](V p, V q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
  // The angle between two corners from their difference, so that nothing cancels.
  const auto angle = [&](V p, V q) {
    const V n = cross_of(p, minus(q, p));
    return std::atan2(std::sqrt(dot_of(n, n)), dot_of(p, q));
  };
  const long double x = angle(v(b), v(c)), y = angle(v(c), v(a)), z = angle(v(a), v(b));
  const long double s = (x + y + z) / 2;
  return 4 *
         std::atan(std::sqrt(std::fmax(0.0L, std::tan(s / 2) * std::tan((s - x) / 2) *
                                                 std::tan((s - y) / 2) * std::tan((s - z) / 2))));
}

TEST(SphericalTriangle, SolidAngleAgreesWithLHuilier) {
  for (const Corners& t : triangles()) {
    if (t.name == "grazing" || t.name == "wide" || t.name == "close") continue;  // it cancels there
    const auto seen = SphericalTriangle::create(t.a, t.b, t.c);
    ASSERT_TRUE(seen) << t.name;
    // The differences of its sides lose as many digits as the triangle is slim.
    EXPECT_NEAR(seen->solid_angle_sr() / double(reference_solid_angle(t.a, t.b, t.c)), 1, 1e-7)
        << t.name;
  }
  EXPECT_DOUBLE_EQ(triangle_solid_angle({1, 0, 0}, {-1, 1, 0}, {-1, 0, 1}), kPi / 2);
}

TEST(SphericalTriangle, TinyOnesSubtendAreaOverDistanceSquared) {
  for (const double size : {1e-3, 1e-5, 1e-8, 1e-12}) {
    const auto seen = SphericalTriangle::create({0, 0, 1}, {size, 0, 1}, {0, size, 1});
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->solid_angle_sr() / (size * size / 2), 1, 2 * size * size + 1e-14) << size;
  }
}

TEST(SphericalTriangle, SampleAndInverseAreOneMap) {
  RandomU random(0x73);
  for (const Corners& t : triangles()) {
    const auto seen = SphericalTriangle::create(t.a, t.b, t.c);
    ASSERT_TRUE(seen) << t.name;
    for (int i = 0; i < 1000; ++i) {
      const auto u = random.pair();
      const Vec3 w = seen->sample(u);
      ASSERT_GE(std::fmin(w.x, std::fmin(w.y, w.z)), 0) << t.name;
      ASSERT_NEAR(w.x + w.y + w.z, 1, 1e-14);
      const auto back = seen->invert(w);
      // Towards b, u.x is the difference of two vanishing weights.
      EXPECT_NEAR(back.x, u.x, 1e-6) << t.name;
      EXPECT_NEAR(back.y, u.y, 1e-6) << t.name;
    }
  }
}

/// Expects the share of samples on one side of a cut to equal that side's share of the solid angle.
/// Cuts go through a corner and a point of the opposite edge: several for each corner.
void expect_shares(const Corners& t, const std::function<Vec3(Vec2)>& sample) {
  constexpr int kSamples = 40000;
  RandomU random(0x74);
  const auto whole = SphericalTriangle::create(t.a, t.b, t.c)->solid_angle_sr();
  const Vec3 corner[3] = {t.a, t.b, t.c};
  int below[3][3] = {};
  constexpr double kCut[3] = {0.2, 0.5, 0.9};
  for (int i = 0; i < kSamples; ++i) {
    const Vec3 w = sample(random.pair());
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) {
        const double p = w[(k + 1) % 3], q = w[(k + 2) % 3];
        below[k][j] += q < kCut[j] * (p + q);
      }
  }
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      const Vec3& p = corner[(k + 1) % 3];
      const Vec3 to_cut = (corner[(k + 2) % 3] - p) * kCut[j];
      const double share =
          triangle_solid_angle(corner[k], p - corner[k], p - corner[k] + to_cut) / whole;
      const double sigma = std::sqrt(share * (1 - share) / kSamples);
      EXPECT_NEAR(double(below[k][j]) / kSamples, share, 5.5 * sigma + 1e-6)
          << t.name << " corner " << k << " cut " << kCut[j];
    }
}

TEST(SphericalTriangle, SamplesAreUniformInSolidAngle) {
  for (const Corners& t : triangles()) {
    const auto seen = *SphericalTriangle::create(t.a, t.b, t.c);
    expect_shares(t, [&](Vec2 u) { return seen.sample(u); });
  }
}

TEST(SphericalTriangle, TestOfUniformityRejectsSamplesByArea) {
  ::testing::TestPartResultArray failures;
  {
    ::testing::ScopedFakeTestPartResultReporter reporter(
        ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &failures);
    const Corners t = triangles()[1];
    expect_shares(t, [](Vec2 u) { return sample_uniform_triangle(u); });
  }
  EXPECT_GT(failures.size(), 0);
}

TEST(SphericalTriangle, HasNoDensityInItsPlaneOnACornerOrNowhere) {
  EXPECT_FALSE(SphericalTriangle::create({1, 0, 0}, {2, 0, 0}, {1, 1, 0}));      // plane
  EXPECT_FALSE(SphericalTriangle::create({0, 0, 0}, {1, 0, 1}, {0, 1, 1}));      // corner
  EXPECT_FALSE(SphericalTriangle::create({-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}));  // within
  EXPECT_FALSE(  // the hemisphere minus 1e-9 sr
      SphericalTriangle::create({-1e9, -1e9, 1}, {2e9, -1e9, 1}, {-1e9, 2e9, 1}));
  EXPECT_FALSE(SphericalTriangle::create({1, 1, 1}, {1, 1, 1}, {2, 1, 1}));  // no area
  EXPECT_FALSE(SphericalTriangle::create({NAN, 0, 1}, {1, 0, 1}, {0, 1, 1}));
  EXPECT_FALSE(SphericalTriangle::create({INFINITY, 0, 1}, {1, 0, 1}, {0, 1, 1}));
}

TEST(SphericalTriangle, ScalesByPowersOfTwoWithoutChangingABit) {
  const auto seen = *SphericalTriangle::create({3, 1, 2}, {-1, 4, 2}, {-2, -1, 2});
  for (const int k : {-900, -60, 60, 900}) {
    const auto s = [k](const Vec3& v) { return scaled(v, k); };
    const auto other = SphericalTriangle::create(s({3, 1, 2}), s({-1, 4, 2}), s({-2, -1, 2}));
    ASSERT_TRUE(other);
    EXPECT_EQ(other->solid_angle_sr(), seen.solid_angle_sr());
    EXPECT_EQ(other->sample({0.3, 0.7}), seen.sample({0.3, 0.7}));
  }
}

struct Box {
  std::string name;
  Vec3 corner, x, y;
};

std::vector<Box> rectangles() {
  return {{"face of a cube", {-1, -1, 1}, {2, 0, 0}, {0, 2, 0}},
          {"aside", {1, 2, 1}, {2, 0, 0}, {0, 3, 0}},
          {"tilted", {1, 0, 2}, {0.6, 0, 0.8}, {0, 3, 0}},
          {"close", {-1, -1, 1e-4}, {2, 0, 0}, {0, 2, 0}},
          {"wide", {-1e5, -1e5, 1}, {3e5, 0, 0}, {0, 2e5, 0}},
          {"small, 4e-4 sr", {0.3, 0.2, 1}, {0.02, 0, 0}, {0, 0.02, 0}},
          {"small, 4e-5 sr", {0.3, 0.2, 3}, {0.02, 0, 0}, {0, 0.02, 0}},
          {"eye nearly in its plane, 5e-4 sr", {1, -0.5, 1e-3}, {1, 0, 0}, {0, 1, 0}},
          {"eye nearly in its plane, 5e-5 sr", {1, -0.5, 1e-4}, {1, 0, 0}, {0, 1, 0}},
          {"nearly in line with an edge", {1, 0, 1e-3}, {1, 0, 0}, {0, 1, 0}}};
}

double solid_angle(const Vec3& corner, const Vec3& x, const Vec3& y) {
  return triangle_solid_angle(corner, x, y) + triangle_solid_angle(corner + x + y, -x, -y);
}

TEST(SphericalRectangle, AFaceOfTheCubeCoversASixth) {
  const auto seen = SphericalRectangle::create({-1, -1, 1}, {2, 0, 0}, {0, 2, 0});
  EXPECT_DOUBLE_EQ(seen->solid_angle_sr(), 4 * kPi / 6);
}

TEST(SphericalRectangle, SamplesAreUniformInSolidAngle) {
  for (const Box& b : rectangles()) {
    const auto seen = SphericalRectangle::create(b.corner, b.x, b.y);
    ASSERT_TRUE(seen) << b.name;
    constexpr int kBins = 12;
    constexpr int kSamples = 60000;
    std::vector<double> observed(kBins * kBins), expected(kBins * kBins);
    RandomU random(0x75);
    for (int i = 0; i < kSamples; ++i) {
      const auto p = seen->sample(random.pair());
      ++observed[std::min(int(p.x * kBins), kBins - 1) * kBins +
                 std::min(int(p.y * kBins), kBins - 1)];
    }
    for (int i = 0; i < kBins; ++i)
      for (int j = 0; j < kBins; ++j)
        expected[i * kBins + j] =
            kSamples *
            solid_angle(b.corner + b.x * (double(i) / kBins) + b.y * (double(j) / kBins),
                        b.x / kBins, b.y / kBins) /
            seen->solid_angle_sr();
    EXPECT_GT(chi_square_p_value(observed, expected), kUnlikely) << b.name;
  }
}

TEST(SphericalRectangle, SampleAndInverseAreOneMap) {
  RandomU random(0x76);
  for (const Box& b : rectangles()) {
    const auto seen = *SphericalRectangle::create(b.corner, b.x, b.y);
    for (int i = 0; i < 1000; ++i) {
      const auto u = random.pair();
      const auto back = seen.invert(seen.sample(u));
      EXPECT_NEAR(back.x, u.x, 1e-6) << b.name;
      EXPECT_NEAR(back.y, u.y, 1e-6) << b.name;
    }
    EXPECT_NEAR(seen.sample({0, 0}).x, 0, 1e-6);
    EXPECT_NEAR(seen.sample({0, 0}).y, 0, 1e-6);
    EXPECT_NEAR(seen.sample({1, 1}).x, 1, 1e-6);
    EXPECT_NEAR(seen.sample({1, 1}).y, 1, 1e-6);
  }
}

TEST(SphericalRectangle, EndsAlongTheFirstEdgeAreExact) {
  for (const Box& b : rectangles()) {
    const auto seen = *SphericalRectangle::create(b.corner, b.x, b.y);
    EXPECT_EQ(seen.sample({0, 0.3}).x, 0) << b.name;
    EXPECT_NEAR(seen.sample({1, 0.3}).x, 1, 0x1p-52) << b.name;
  }
}

TEST(SphericalRectangle, DoesNotExistBelowTheThreshold) {
  EXPECT_FALSE(SphericalRectangle::create({0.3, 0.2, 30}, {0.02, 0, 0}, {0, 0.02, 0}));
  EXPECT_FALSE(SphericalRectangle::create({1, 1, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(SphericalRectangle::create({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  EXPECT_FALSE(SphericalRectangle::create({NAN, -1, 0}, {2, 0, 0}, {0, 2, 0}));
}

TEST(BilinearWeights, SamplesFollowTheWeights) {
  const BilinearWeights w{1, 0, 2, 5};
  RandomU random(0x77);
  constexpr int kBins = 16;
  constexpr int kSamples = 50000;
  std::vector<double> observed(kBins * kBins), expected(kBins * kBins);
  for (int i = 0; i < kSamples; ++i) {
    const auto p = w.sample(random.pair());
    ++observed[std::min(int(p.x * kBins), kBins - 1) * kBins +
               std::min(int(p.y * kBins), kBins - 1)];
  }
  for (int i = 0; i < kBins; ++i)
    for (int j = 0; j < kBins; ++j)  // the mean of a bilinear function is its value in the middle
      expected[i * kBins + j] =
          kSamples * w.pdf({(i + 0.5) / kBins, (j + 0.5) / kBins}) / (kBins * kBins);
  EXPECT_GT(chi_square_p_value(observed, expected), kUnlikely);
}

}  // namespace
}  // namespace lucerna::testing
