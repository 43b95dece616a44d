// Points of flat and spherical triangles and rectangles: invertible, correct for extreme inputs.
#include <gtest/gtest.h>

#include <cmath>
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

}  // namespace
}  // namespace lucerna::testing
