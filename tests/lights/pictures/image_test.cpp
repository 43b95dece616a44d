#include "lights/pictures/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace lucerna {
namespace {

std::shared_ptr<const Image> grey(int width, int height, const std::vector<float>& values) {
  std::vector<Rgbf> texels;
  for (const float v : values) texels.emplace_back(v);
  return *Image::create(width, height, std::move(texels));
}

TEST(Image, NearestShowsATexelAllOverItsSquare) {
  const auto image = grey(2, 2, {1, 2, 3, 4});
  const auto at = [&](double x, double y) {
    return image->lookup({x, y}, ImageFilter::kNearest, ImageBorder::kClamp).g;
  };
  EXPECT_EQ(at(0, 0), 1);
  EXPECT_EQ(at(0.499, 0.499), 1);
  EXPECT_EQ(at(0.5, 0.499), 2);
  EXPECT_EQ(at(0.499, 0.5), 3);
  EXPECT_EQ(at(1, 1), 4);
}

TEST(Image, BilinearIsTheTexelAtItsCentreAndTheMeanHalfway) {
  const auto image = grey(2, 2, {1, 2, 3, 8});
  const auto at = [&](double x, double y) {
    return image->lookup({x, y}, ImageFilter::kBilinear, ImageBorder::kClamp).g;
  };
  EXPECT_EQ(at(0.25, 0.25), 1);
  EXPECT_EQ(at(0.75, 0.25), 2);
  EXPECT_EQ(at(0.5, 0.25), 1.5);
  EXPECT_EQ(at(0.5, 0.5), 3.5);
  EXPECT_EQ(at(0, 0), 1);
  EXPECT_EQ(at(1, 0.75), 8);
}

TEST(Image, LatitudeLongitudeJoinsLeftAndRightAndContinuesBeyondThePoles) {
  const auto image = grey(4, 2, {1, 2, 3, 4, 5, 6, 7, 8});
  const auto at = [&](double x, double y) {
    return image->lookup({x, y}, ImageFilter::kBilinear, ImageBorder::kLatitudeLongitude).g;
  };
  EXPECT_EQ(at(0, 0.25), 2.5);  // between columns 0 and 3
  EXPECT_EQ(at(1, 0.25), 2.5);
  // At the pole, halfway to the texel half a turn away.
  EXPECT_EQ(at(0.125, 0), 2);  // columns 0 and 2
  EXPECT_EQ(at(0.625, 1), 6);  // columns 2 and 0
  EXPECT_EQ(at(0.125, 0.25), 1);
}

TEST(Image, OctahedralEdgesMeetThemselvesTurnedAboutTheirMiddle) {
  const auto image = grey(2, 2, {1, 2, 3, 8});
  const auto at = [&](double x, double y) {
    return image->lookup({x, y}, ImageFilter::kBilinear, ImageBorder::kOctahedral).g;
  };
  // The left edge joins (0, v) to (0, 1 - v), the upper one (u, 0) to (1 - u, 0).
  for (const double t : {0.0, 0.1, 0.25, 0.4, 0.5}) {
    EXPECT_NEAR(at(0, t), at(0, 1 - t), 1e-15) << t;
    EXPECT_NEAR(at(1, t), at(1, 1 - t), 1e-15) << t;
    EXPECT_NEAR(at(t, 0), at(1 - t, 0), 1e-15) << t;
    EXPECT_NEAR(at(t, 1), at(1 - t, 1), 1e-15) << t;
  }
  EXPECT_EQ(at(0, 0.25), 2);  // rows 0 and 1 of column 0
  // All four corners are one direction.
  EXPECT_EQ(at(0, 0), at(1, 1));
  EXPECT_EQ(at(0, 0), at(1, 0));
}

TEST(Image, MeanIsTheIntegralOfEveryFilter) {
  const auto image = grey(4, 4, {1, 0, 3, 9, 2, 7, 4, 4, 1, 6, 2, 2, 8, 1, 5, 3});
  EXPECT_EQ(image->mean().g, 58 / 16.0);
  for (const auto border :
       {ImageBorder::kClamp, ImageBorder::kLatitudeLongitude, ImageBorder::kOctahedral}) {
    for (const auto filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
      // The midpoint rule is exact for functions that are bilinear in each square of 1/8.
      double sum = 0;
      for (int i = 0; i < 64; ++i)
        sum += image->lookup({(i % 8 + 0.5) / 8, (i / 8 + 0.5) / 8}, filter, border).g;
      EXPECT_NEAR(sum / 64, 58 / 16.0, 1e-14);
    }
  }
}

TEST(Image, OneTexelIsTheSameEverywhere) {
  const auto image = grey(1, 1, {3});
  for (const auto border :
       {ImageBorder::kClamp, ImageBorder::kLatitudeLongitude, ImageBorder::kOctahedral})
    for (const auto filter : {ImageFilter::kNearest, ImageFilter::kBilinear})
      for (const double x : {0.0, 0.3, 0.5, 0.9, 1.0})
        EXPECT_EQ(image->lookup({x, 1 - x}, filter, border).r, 3);
}

TEST(Image, CreateNamesTheInvalidTexel) {
  std::vector<Rgbf> texels(6, Rgbf(1));
  texels[4].g = NAN;
  EXPECT_THAT(std::string(Image::create(3, 2, texels).status().message()),
              ::testing::HasSubstr("texel (1, 1)"));
  texels[4].g = -1;
  EXPECT_FALSE(Image::create(3, 2, texels).ok());
  texels[4].g = INFINITY;
  EXPECT_FALSE(Image::create(3, 2, texels).ok());
  texels[4].g = 0;
  EXPECT_TRUE(Image::create(3, 2, texels).ok());
  EXPECT_THAT(std::string(Image::create(0, 0, {}).status().message()),
              ::testing::HasSubstr("0 x 0"));
  EXPECT_FALSE(Image::create(2, 2, texels).ok());
}

}  // namespace
}  // namespace lucerna
