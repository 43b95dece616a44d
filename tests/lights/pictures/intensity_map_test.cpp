#include "lights/pictures/intensity_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lights/maths/normal_cone.h"
#include "lights/maths/vec.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using testing::RandomU;
using testing::Region;

constexpr auto kMappings = {SphereMapping::kEqualArea, SphereMapping::kLatitudeLongitude};
constexpr auto kFilters = {ImageFilter::kNearest, ImageFilter::kBilinear};

std::shared_ptr<const Image> image(int width, int height, std::vector<Rgbf> texels) {
  return *Image::create(width, height, std::move(texels));
}

/// `lit` texels have random values, the others are black.
std::shared_ptr<const IntensityMap> sparse(int side, const std::vector<int>& lit,
                                           SphereMapping mapping, ImageFilter filter) {
  std::vector<Rgbf> texels(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  RandomU random(41);
  for (const int i : lit) texels[static_cast<std::size_t>(i)] = Rgbf(1 + random.next());
  return *IntensityMap::create(image(side, side, std::move(texels)), mapping, filter);
}

std::vector<std::vector<int>> patterns() {
  std::vector<int> all(64);
  for (int i = 0; i < 64; ++i) all[static_cast<std::size_t>(i)] = i;
  // A corner, an edge, beside the middle, several in a row, all.
  return {{0}, {4}, {27}, {18, 19, 20}, all};
}

TEST(IntensityMap, TakesTheMeanOfChannelsAndSharesGreyPictures) {
  const auto colours = image(1, 2, {{3, 6, 0}, {0, 0, 7.5F}});
  const auto map =
      *IntensityMap::create(colours, SphereMapping::kLatitudeLongitude, ImageFilter::kNearest);
  EXPECT_EQ(map->at({0, 1, 0}), 3);
  EXPECT_EQ(map->at({1, -5, 0}), 2.5);  // of any length
  EXPECT_EQ(map->max_cd(), 3);
  EXPECT_EQ(map->mean_cd(), 2.75);
  EXPECT_NEAR(map->flux_lm(), 2 * kPi * 3 + 2 * kPi * 2.5, 1e-12);
  EXPECT_FALSE(is_grey(*colours));
  const auto grey = image(1, 1, {Rgbf(0.1F)});
  EXPECT_TRUE(is_grey(*grey));
  const auto shared =
      *IntensityMap::create(grey, SphereMapping::kEqualArea, ImageFilter::kBilinear);
  EXPECT_EQ(&shared->sphere_map().image(), grey.get());
  EXPECT_EQ(shared->at({0, 0, -3}), double{0.1F});
}

TEST(IntensityMap, ConeHoldsAllLightAndLittleMore) {
  RandomU random(43);
  for (const auto mapping : kMappings)
    for (const auto filter : kFilters)
      for (const auto& lit : patterns()) {
        const auto map = sparse(8, lit, mapping, filter);
        double widest = 0;
        for (int i = 0; i < 50000; ++i) {
          const Vec3 w = Region{}.at(random.next(), random.next());
          if (map->at(w) == 0) continue;
          const double angle = angle_between(map->cone().axis, w);
          ASSERT_LE(angle, map->cone().half_angle_rad);
          widest = std::max(widest, angle);
        }
        EXPECT_NEAR(length(map->cone().axis), 1, 1e-15);
        // One texel among 8 x 8 gets at most the margin of its Lipschitz bound beyond its corners.
        if (lit.size() == 1) {
          EXPECT_LT(map->cone().half_angle_rad, widest + 1);
        }
      }
  // One texel of 1000 x 1000: a few thousandths.
  const auto narrow =
      sparse(1000, {400 * 1000 + 300}, SphereMapping::kEqualArea, ImageFilter::kNearest);
  EXPECT_LT(narrow->cone().half_angle_rad, 5e-3);
  EXPECT_LT(angle_between(narrow->cone().axis,
                          direction_from_square(SphereMapping::kEqualArea, {0.3005, 0.4005})),
            1e-12);
}

TEST(IntensityMap, BlackPicturesHaveNoFluxAndInvalidMapsAreRefused) {
  const auto black = *IntensityMap::create(image(2, 2, std::vector<Rgbf>(4)),
                                           SphereMapping::kEqualArea, ImageFilter::kNearest);
  EXPECT_EQ(black->flux_lm(), 0);
  EXPECT_EQ(black->max_cd(), 0);
  EXPECT_EQ(black->pdf({0, 0, 1}).per_sr, 0);
  const auto oblong = IntensityMap::create(image(2, 1, std::vector<Rgbf>(2)),
                                           SphereMapping::kEqualArea, ImageFilter::kNearest);
  EXPECT_THAT(std::string(oblong.status().message()),
              ::testing::HasSubstr("2 x 1 texels, allowed: square"));
  EXPECT_FALSE(
      IntensityMap::create(nullptr, SphereMapping::kEqualArea, ImageFilter::kNearest).ok());
}

}  // namespace
}  // namespace lucerna
