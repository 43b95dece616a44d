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

TEST(SphereMap, IntegralOfOneIsThatOfTheSphereForAnyNumberOfRows) {
  for (const auto filter : {ImageFilter::kNearest, ImageFilter::kBilinear})
    for (const int height : {1, 2, 7, 1000, 100000}) {
      const auto one = *SphereMap::create(
          *Image::create(1, height, std::vector<Rgbf>(static_cast<std::size_t>(height), Rgbf(1))),
          SphereMapping::kLatitudeLongitude, filter);
      EXPECT_NEAR(one->integral().r, 4 * kPi, 1e-10) << height;
    }
}

TEST(SphereMap, EqualAreaTakesSquarePicturesOnly) {
  const auto status = SphereMap::create(*Image::create(4, 2, std::vector<Rgbf>(8)),
                                        SphereMapping::kEqualArea, ImageFilter::kNearest)
                          .status();
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

}  // namespace
}  // namespace lucerna
