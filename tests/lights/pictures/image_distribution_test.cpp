#include "lights/pictures/image_distribution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using testing::chi_square_p_value;
using testing::RandomU;

using Kind = std::tuple<ImageFilter, ImageBorder>;
class AnyDistribution : public ::testing::TestWithParam<Kind> {
 protected:
  const ImageFilter filter_ = std::get<0>(GetParam());
  const ImageBorder border_ = std::get<1>(GetParam());
};

std::shared_ptr<const Image> random_image(int width, int height) {
  RandomU random(7);
  std::vector<Rgbf> texels;
  for (int i = 0; i < width * height; ++i) {
    const float v = random.next();
    // A third is black, the others span three decades.
    texels.push_back(random.next() < 0.33F ? Rgbf{}
                                           : Rgbf(v, random.next(), 1) * (1000 * v * v * v));
  }
  return *Image::create(width, height, std::move(texels));
}

TEST_P(AnyDistribution, DensityIsTheFilteredLuminanceOverItsIntegral) {
  const auto image = random_image(6, 6);
  const ImageDistribution d(*image, filter_, border_);
  EXPECT_NEAR(d.integral(), luminance(image->mean()), 1e-12 * d.integral());
  RandomU random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec2 p = random.pair();
    const double shown = luminance(image->lookup(p, filter_, border_));
    EXPECT_NEAR(d.pdf(p), shown / d.integral(), 1e-12 * (1 + shown));
  }
}

TEST_P(AnyDistribution, SamplesFollowTheDensity) {
  const auto image = random_image(6, 6);
  const ImageDistribution d(*image, filter_, border_);
  constexpr int kSamples = 200000, kBins = 24, kSub = 8;
  std::vector<double> observed(kBins * kBins), expected(kBins * kBins), wrong(kBins * kBins);
  RandomU random(2);
  for (int i = 0; i < kSamples; ++i) {
    const auto s = d.sample(random.pair());
    ASSERT_GT(s.pdf, 0);
    ASSERT_NEAR(s.pdf, d.pdf(s.position), 1e-9 * s.pdf);
    ++observed[std::min(int(s.position.y * kBins), kBins - 1) * kBins +
               std::min(int(s.position.x * kBins), kBins - 1)];
  }
  // Bins divide texels and the cells between centres, so the midpoint rule is exact.
  constexpr int kFine = kBins * kSub;
  for (int y = 0; y < kFine; ++y)
    for (int x = 0; x < kFine; ++x) {
      const double n = double(kSamples) / (kFine * kFine);
      const Vec2 p{(x + 0.5) / kFine, (y + 0.5) / kFine};
      expected[y / kSub * kBins + x / kSub] += n * d.pdf(p);
      wrong[y / kSub * kBins + x / kSub] += n * d.pdf({p.x, 1 - p.y});
    }
  EXPECT_GT(chi_square_p_value(observed, expected), 1e-8);
  EXPECT_LT(chi_square_p_value(observed, wrong), 1e-8) << "the test notices no mistake";
}

TEST_P(AnyDistribution, EverySampleHasALitPointAndItsDensityAlsoAtTheEdgesOfU) {
  for (const int lit : {0, 5, 24, 35}) {
    std::vector<Rgbf> texels(36);
    texels[static_cast<std::size_t>(lit)] = Rgbf(1);
    const auto image = *Image::create(6, 6, std::move(texels));
    const ImageDistribution d(*image, filter_, border_);
    EXPECT_NEAR(d.integral(), 1 / 36.0, 1e-15);
    for (const double x : {0., 0x1p-24, 0.3, 0.5, 1 - 0x1p-24, 1.})
      for (const double y : {0., 0x1p-24, 0.3, 0.5, 1 - 0x1p-24, 1.}) {
        const auto s = d.sample({x, y});
        EXPECT_TRUE(s.pdf > 0 && std::isfinite(s.pdf)) << lit << " " << x << " " << y;
        EXPECT_TRUE(s.position.x >= 0 && s.position.x <= 1);
        EXPECT_TRUE(s.position.y >= 0 && s.position.y <= 1);
        EXPECT_GT(luminance(image->lookup(s.position, filter_, border_)), 0);
      }
  }
}

TEST_P(AnyDistribution, ATexelOf1e9LeavesTheOthersTheirShare) {
  std::vector<Rgbf> texels(36, Rgbf(1));
  texels[14] = Rgbf(1e9F);
  const auto image = *Image::create(6, 6, std::move(texels));
  const ImageDistribution d(*image, filter_, border_);
  // Far from the bright texel the density is 1 over the mean, 36 / (1e9 + 35).
  EXPECT_NEAR(d.pdf({0.9, 0.9}) * (1e9 + 35) / 36, 1, 1e-9);
  // The samples of the last row begin at 1 - 6 / (1e9 + 35).
  const auto s = d.sample({0.5, 1 - 2 / 1e9});
  EXPECT_GT(s.position.y, 5 / 6.0 - 0.1);
  EXPECT_NEAR(s.pdf * (1e9 + 35) / 36, 1, 1e-9);
}

TEST_P(AnyDistribution, ABlackPictureHasNoDensity) {
  const auto image = *Image::create(6, 6, std::vector<Rgbf>(36));
  const ImageDistribution d(*image, filter_, border_);
  EXPECT_EQ(d.integral(), 0);
  EXPECT_EQ(d.sample({0.5, 0.5}).pdf, 0);
  EXPECT_EQ(d.pdf({0.5, 0.5}), 0);
}

TEST_P(AnyDistribution, RowMeasuresScaleRows) {
  const auto image = random_image(6, 6);
  const ImageDistribution flat(*image, filter_, border_);
  std::vector<double> weights;
  for (int i = 0; i < 36; ++i) weights.push_back(luminance(Rgb(image->texel(i % 6, i / 6))));
  // The second row of cells has weight 0, the fourth weight 3.
  std::vector<double> measures;
  const bool nearest = filter_ == ImageFilter::kNearest;
  for (int r = 0; r < (nearest ? 6 : 7); ++r)
    measures.push_back((r == 1   ? 0.0
                        : r == 3 ? 3.0
                                 : 1.0) *
                       (!nearest && (r == 0 || r == 6) ? 1 / 12.0 : 1 / 6.0));
  const ImageDistribution d(6, 6, weights, filter_, border_, measures);
  const double y1 = nearest ? 1.5 / 6 : 1.0 / 6, y3 = nearest ? 3.5 / 6 : 3.0 / 6;
  for (const double x : {0.05, 0.3, 0.8}) {
    EXPECT_EQ(d.pdf({x, y1}), 0);
    EXPECT_NEAR(d.pdf({x, y3}) * d.integral(), 3 * flat.pdf({x, y3}) * flat.integral(), 1e-12);
  }
  RandomU random(3);
  for (int i = 0; i < 1000; ++i) EXPECT_GT(d.pdf(d.sample(random.pair()).position), 0);
}

TEST(ImageDistribution, AHundredThousandTexelsInOneRow) {
  std::vector<Rgbf> texels(100000, Rgbf(1));
  texels[77777] = Rgbf(100001);
  const auto image = *Image::create(100000, 1, std::move(texels));
  for (const auto filter : {ImageFilter::kNearest, ImageFilter::kBilinear}) {
    const ImageDistribution d(*image, filter, ImageBorder::kClamp);
    EXPECT_NEAR(d.integral(), 2, 1e-9);
    // Half of all samples lie on the bright texel, which begins at a share of 77777 / 200000.
    EXPECT_NEAR(d.sample({0.6, 0.5}).position.x, 0.777775, 1e-5);
    EXPECT_NEAR(d.sample({0.2, 0.5}).position.x, 0.4, 1e-5);
    EXPECT_NEAR(d.sample({0.95, 0.5}).position.x, 0.9, 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Filters, AnyDistribution,
    ::testing::Combine(::testing::Values(ImageFilter::kNearest, ImageFilter::kBilinear),
                       ::testing::Values(ImageBorder::kClamp, ImageBorder::kLatitudeLongitude,
                                         ImageBorder::kOctahedral)));

}  // namespace
}  // namespace lucerna
