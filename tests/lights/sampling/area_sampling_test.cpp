// The sampling method that the automatic rule chooses, and the variance that it reaches.
#include "lights/sampling/area_sampling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/area_helpers.h"

namespace lucerna::testing {
namespace {

constexpr AreaSampling kWays[] = {AreaSampling::kSquareRoot,      AreaSampling::kKraemer,
                                  AreaSampling::kParallelogram,   AreaSampling::kRejection,
                                  AreaSampling::kLowDistortion,   AreaSampling::kSolidAngle,
                                  AreaSampling::kCosineSolidAngle};

/// The square |x|, |y| < 1/2 seen from `receiver`.
std::vector<Vec3> square_from(const Vec3& receiver) {
  std::vector<Vec3> corners;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) corners.push_back(Vec3{x, y, 0} - receiver);
  return corners;
}

TEST(AreaSamplingRule, KeepsTheRequestedMethodWhereItApplies) {
  const auto near = square_from({0, 0, 0.25}), far = square_from({0, 0, 50});
  const Vec3 n{0, 0, -1};
  for (const AreaSampling way : kWays) {
    EXPECT_EQ(way_for_corners(way, near, n), way);
    EXPECT_EQ(way_for_corners(way, far, n), way);
    const bool cosine = way == AreaSampling::kCosineSolidAngle;
    const AreaSampling without = cosine ? AreaSampling::kSolidAngle : way;
    EXPECT_EQ(way_for_corners(way, near, {}), without);
    EXPECT_EQ(way_for_disk(way, {1, 0, 1}, {2, 0, 1}), without);
    EXPECT_EQ(is_by_area(way_for_sphere(way)), is_by_area(way));
  }
}

TEST(AreaSamplingRule, UsesAreaFarAwaySolidAngleNearbyAndTheCosineWhereItVaries) {
  const auto automatic = [](const Vec3& receiver, const Vec3& n) {
    return way_for_corners(AreaSampling::kAutomatic, square_from(receiver), normalized(n));
  };
  const Vec3 none, facing{0, 0, -1}, aslant{1, 0, 0};
  for (const Vec3& n : {none, facing}) {
    EXPECT_EQ(automatic({0, 0, 0.5}, n), AreaSampling::kSolidAngle);
    EXPECT_EQ(automatic({3, 0, 1}, none), AreaSampling::kSolidAngle);
    EXPECT_TRUE(is_by_area(automatic({0, 0, 4}, n)));
    EXPECT_TRUE(is_by_area(automatic({30, 0, 10}, n)));
  }
  // The horizon cuts the light, or one edge is much nearer than the other.
  for (const double d : {0.1, 0.5, 4.})
    EXPECT_EQ(automatic({0, 0, d}, aslant), AreaSampling::kCosineSolidAngle) << d;
  EXPECT_TRUE(is_by_area(automatic({0, 0, 100}, aslant)));  // cosines within the floor
  EXPECT_EQ(automatic({0.6, 0, 0.1}, facing), AreaSampling::kCosineSolidAngle);
  // The light is below the horizon, so every method gives none.
  EXPECT_TRUE(is_by_area(automatic({0, 0, 4}, -facing)));
  const auto disk = [](double offset, double height) {
    return way_for_disk(AreaSampling::kAutomatic, {offset - 0.5, 0, height},
                        {offset + 0.5, 0, height});
  };
  EXPECT_EQ(disk(0, 0.5), AreaSampling::kSolidAngle);
  EXPECT_EQ(disk(2, 1), AreaSampling::kSolidAngle);
  EXPECT_TRUE(is_by_area(disk(0, 4)));
  EXPECT_EQ(way_for_sphere(AreaSampling::kAutomatic), AreaSampling::kSolidAngle);
}

TEST(AreaSamplingRule, DoesNotChangeWithTheUnitOfLength) {
  const Vec3 n = normalized(Vec3{0.3, 0.2, -1});
  RandomU random(0xa5);
  for (int i = 0; i < 1000; ++i) {
    const auto corners = square_from({4 * random.next(), 4 * random.next(), 3 * random.next()});
    const AreaSampling way = way_for_corners(AreaSampling::kAutomatic, corners, n);
    for (const int k : {-60, -1, 60}) {
      auto other = corners;
      for (auto& c : other) c = scaled(c, k);
      EXPECT_EQ(way_for_corners(AreaSampling::kAutomatic, other, n), way);
    }
  }
}

/// Relative variance of one sample of the irradiance.
template <typename Light>
double variance(const Light& light, const Vec3& at, const Vec3& n, AreaSampling way) {
  Receiver receiver{Vec3(at)};
  receiver.normal = Vec3(n);
  receiver.area_sampling = way;
  constexpr int kSamples = 40000;
  const Estimate e = illuminance(light, receiver, n, 0xa6, kSamples);
  return e.standard_error * e.standard_error * kSamples / (e.mean * e.mean);
}

template <typename Light>
double mean(const Light& light, const Vec3& at, const Vec3& n) {
  return illuminance(light, by_area(Vec3(at)), n, 0xa7).mean;
}

TEST(AreaSamplingRule, VarianceIsNearTheLeastOfAllMethods) {
  using V = Vec3;
  const auto square = *AreaLight::create(
      {Rgb(1), true}, *PatchMesh::create({{V{-0.5F, -0.5F, 0}, V{0.5F, -0.5F, 0}, V{-0.5F, 0.5F, 0},
                                           V{0.5F, 0.5F, 0}}}));
  const auto triangle = *AreaLight::create(
      {Rgb(1), true},
      *TriangleMesh::create({{V{-0.5F, -0.5F, 0}, V{0.5F, -0.5F, 0}, V{-0.5F, 0.5F, 0}}}));
  const auto disk = *AreaLight::create({Rgb(1), true}, *Disk::create({.radius_m = 0.5}));
  const auto sphere = *AreaLight::create({Rgb(1)}, *Sphere::create({.radius_m = 0.04}));
  for (const double d : {0.1, 0.5, 2., 10.})
    for (const Vec3& direction : {Vec3{0, 0, -1}, {1, 0.2, -0.1}, {0.3, 0.2, -1}}) {
      const Vec3 n = normalized(direction), at{0.1 * d, 0.05 * d, d};
      const auto check = [&](const auto& light, const char* what) {
        // Leaves out places where almost nothing of the light is above the horizon.
        if (mean(light, at, n) < 0.05 * mean(light, at, normalized(-at))) return;
        double least = INFINITY;
        for (const AreaSampling way : kWays) least = std::fmin(least, variance(light, at, n, way));
        // 0.02 is at most the variance of a cosine that varies by a half.  It is less than a tenth
        // of the variance that any shadow adds.
        EXPECT_LT(variance(light, at, n, AreaSampling::kAutomatic), 1.1 * least + 0.02)
            << what << " " << d << " away, normal " << n.x;
      };
      check(square, "square");
      check(triangle, "triangle");
      check(disk, "disk");
      check(sphere, "sphere");
    }
}

}  // namespace
}  // namespace lucerna::testing
