#include "lights/pictures/sphere_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lights/maths/vec.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using testing::RandomU;
constexpr auto kBoth = {SphereMapping::kEqualArea, SphereMapping::kLatitudeLongitude};

Vec3 random_direction(RandomU& random) {
  const double z = 2.0 * random.next() - 1, phi = 2 * kPi * random.next();
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

TEST(SphereMapping, IsInvertible) {
  RandomU random(1);
  for (const auto mapping : kBoth) {
    for (int i = 0; i < 1000; ++i) {
      const Vec3 w = random_direction(random);
      const Vec3 back = direction_from_square(mapping, square_from_direction(mapping, w));
      EXPECT_LT(length(back - w), 1e-14);
    }
    // Very near to the poles too.
    for (const double tiny : {1e-3, 1e-8, 1e-12}) {
      for (const Vec3& w :
           {Vec3{tiny, -tiny, 1}, {tiny, tiny, -1}, {-tiny, 1, tiny}, {tiny, -1, tiny}}) {
        const Vec3 unit = normalized(w);
        const Vec3 back = direction_from_square(mapping, square_from_direction(mapping, unit));
        EXPECT_LT(length(back - unit), 1e-15 + 1e-7 * tiny);
      }
    }
  }
}

TEST(SphereMapping, AxesLieAsInTheTextbooks) {
  const auto equal_area = [](double x, double y) {
    return direction_from_square(SphereMapping::kEqualArea, {x, y});
  };
  EXPECT_LT(length(equal_area(0.5, 0.5) - Vec3{0, 0, 1}), 1e-15);
  EXPECT_LT(length(equal_area(1, 0.5) - Vec3{1, 0, 0}), 1e-15);
  EXPECT_LT(length(equal_area(0.5, 1) - Vec3{0, 1, 0}), 1e-15);
  for (const double x : {0., 1.})
    for (const double y : {0., 1.}) EXPECT_LT(length(equal_area(x, y) - Vec3{0, 0, -1}), 1e-15);
  const auto latlong = [](double x, double y) {
    return direction_from_square(SphereMapping::kLatitudeLongitude, {x, y});
  };
  EXPECT_LT(length(latlong(0.3, 0) - Vec3{0, 1, 0}), 1e-15);
  EXPECT_LT(length(latlong(0, 0.5) - Vec3{1, 0, 0}), 1e-15);
  EXPECT_LT(length(latlong(0.25, 0.5) - Vec3{0, 0, 1}), 1e-15);
  EXPECT_LT(length(latlong(0.7, 1) - Vec3{0, -1, 0}), 1e-15);
}

TEST(SphereMapping, EqualAreasAreEqualSolidAngles) {
  // Uniform directions fall evenly into 8 x 8 squares.
  RandomU random(2);
  constexpr int kSamples = 200000;
  std::vector<double> observed(64), expected(64, kSamples / 64.0);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 p = square_from_direction(SphereMapping::kEqualArea, random_direction(random));
    ++observed[static_cast<std::size_t>(std::min(7, int(p.y * 8)) * 8 + std::min(7, int(p.x * 8)))];
  }
  EXPECT_GT(testing::chi_square_p_value(observed, expected), 1e-8);
}

std::shared_ptr<const Image> noise(int width, int height) {
  RandomU random(3);
  std::vector<Rgbf> texels;
  for (int i = 0; i < width * height; ++i)
    texels.emplace_back(random.next(), random.next(), random.next() < 0.5F ? 0.0F : 1.0F);
  return *Image::create(width, height, std::move(texels));
}

TEST(SphereMap, BilinearLookupIsContinuousAcrossSeamsAndPoles) {
  const auto equal_area =
      *SphereMap::create(noise(8, 8), SphereMapping::kEqualArea, ImageFilter::kBilinear);
  const auto latlong =
      *SphereMap::create(noise(8, 4), SphereMapping::kLatitudeLongitude, ImageFilter::kBilinear);
  RandomU random(4);
  constexpr double kStep = 1e-9;
  for (int i = 0; i < 500; ++i) {
    const double t = 2 * random.next() - 1.0;
    // Across the seam of longitudes, and that of the octahedron's lower half (x = 0 and y = 0).
    const Vec3 a = normalized(Vec3{1, t, 0}), side{0, 0, kStep};
    EXPECT_LT(std::fabs(luminance(latlong->lookup(a + side) - latlong->lookup(a - side))), 1e-7);
    const Vec3 b = normalized(Vec3{t, 0, -1}), across{0, kStep, 0};
    EXPECT_LT(std::fabs(luminance(equal_area->lookup(normalized(b + across)) -
                                  equal_area->lookup(normalized(b - across)))),
              1e-6);
    // Along a meridian over the pole.
    const double phi = kPi * t;
    const Vec3 s{kStep * std::cos(phi), 0, kStep * std::sin(phi)};
    for (const Vec3& pole : {Vec3{0, 1, 0}, {0, -1, 0}})
      EXPECT_LT(std::fabs(luminance(latlong->lookup(pole + s) - latlong->lookup(pole - s))), 1e-6);
  }
}

TEST(SphereMap, IntegralEqualsThatOfTheLookup) {
  for (const auto filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
    for (const auto& [width, height] : {std::pair{1, 1}, {6, 3}, {5, 1}, {8, 4}}) {
      const auto map =
          *SphereMap::create(noise(width, height), SphereMapping::kLatitudeLongitude, filter);
      // The midpoint rule in the cosine and the longitude.  Boundaries of texels cut its cells.
      constexpr int kRows = 1200, kColumns = 240;
      Rgb sum;
      for (int j = 0; j < kRows; ++j) {
        const double y = 1 - 2 * (j + 0.5) / kRows, r = std::sqrt(1 - y * y);
        for (int i = 0; i < kColumns; ++i) {
          const double phi = 2 * kPi * (i + 0.5) / kColumns;
          sum += map->lookup({r * std::cos(phi), y, r * std::sin(phi)});
        }
      }
      const Rgb integral = sum * (4 * kPi / (kRows * kColumns));
      EXPECT_NEAR(luminance(map->integral()), luminance(integral), 1e-3 * luminance(integral));
    }
    // A picture of 1: 4 pi, for any number of rows.
    for (const int height : {1, 2, 7, 1000, 100000}) {
      const auto one = *SphereMap::create(
          *Image::create(1, height, std::vector<Rgbf>(static_cast<std::size_t>(height), Rgbf(1))),
          SphereMapping::kLatitudeLongitude, filter);
      EXPECT_NEAR(one->integral().r, 4 * kPi, 1e-10) << height;
    }
  }
}

TEST(SphereMap, EqualAreaTakesSquarePicturesOnly) {
  const auto status =
      SphereMap::create(noise(4, 2), SphereMapping::kEqualArea, ImageFilter::kNearest).status();
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("4 x 2 texels, allowed: square"));
  EXPECT_FALSE(SphereMap::create(nullptr, SphereMapping::kEqualArea, ImageFilter::kNearest).ok());
}

TEST(SphereDistribution, DensityIsPositiveWhereverTheValueIs) {
  for (const auto mapping : kBoth) {
    for (const auto filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
      // A single lit texel: at the corner, at an edge, inside.
      for (const int lit : {0, 3, 21}) {
        std::vector<Rgbf> texels(64);
        texels[static_cast<std::size_t>(lit)] = Rgbf(1);
        const auto map = *SphereMap::create(*Image::create(8, 8, texels), mapping, filter);
        const SphereDistribution distribution(*map);
        RandomU random(5);
        for (int i = 0; i < 20000; ++i) {
          const Vec3 w = random_direction(random);
          if (luminance(map->lookup(w)) > 1e-12) {
            ASSERT_GT(distribution.per_sr(w), 0);
          }
        }
        for (const double x : {0., 0x1p-24, 0.5, 1 - 0x1p-24, 1.})
          for (const double y : {0., 0x1p-24, 0.5, 1 - 0x1p-24, 1.}) {
            const auto s = distribution.sample({x, y});
            EXPECT_TRUE(s.per_sr > 0 && std::isfinite(s.per_sr));
            EXPECT_GT(luminance(map->lookup(s.position)), 0);
          }
      }
    }
  }
}

TEST(SphereDistribution, NearestIsExactlyProportionalToLuminance) {
  const auto map =
      *SphereMap::create(noise(8, 8), SphereMapping::kLatitudeLongitude, ImageFilter::kNearest);
  const SphereDistribution distribution(*map);
  RandomU random(6);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 w = random_direction(random);
    EXPECT_NEAR(distribution.per_sr(w) * luminance(map->integral()), luminance(map->lookup(w)),
                1e-12);
    const auto s = distribution.sample(random.pair());
    EXPECT_NEAR(s.per_sr * luminance(map->integral()), luminance(map->lookup(s.position)), 1e-12);
  }
}

TEST(SphereDistribution, ABlackMapIsEmpty) {
  const auto map = *SphereMap::create(*Image::create(2, 2, std::vector<Rgbf>(4)),
                                      SphereMapping::kEqualArea, ImageFilter::kNearest);
  const SphereDistribution distribution(*map);
  EXPECT_TRUE(distribution.empty());
  EXPECT_EQ(distribution.sample({0.5, 0.5}).per_sr, 0);
  EXPECT_EQ(distribution.per_sr({0, 0, 1}), 0);
}

}  // namespace
}  // namespace lucerna
