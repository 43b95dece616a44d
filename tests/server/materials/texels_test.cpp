// The memory of pictures on surfaces.
#include "server/materials/texels.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lucerna {
namespace {

template <typename F>
std::shared_ptr<const Image> picture(int width, int height, F&& f) {
  std::vector<Rgbf> texels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) texels.push_back(f(x, y));
  return *Image::create(width, height, std::move(texels));
}

float of_byte(int code) { return std::pow(static_cast<float>(code % 256) / 255.0F, 2.2F); }

void expect_equal(const Texels& texels, const Image& image) {
  ASSERT_EQ(texels.width(), image.width());
  ASSERT_EQ(texels.height(), image.height());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      ASSERT_EQ(texels.texel(x, y), Rgb(image.texel(x, y))) << x << ", " << y;
}

TEST(Texels, PicturesOfEightBitsHaveABytePerChannel) {
  const auto colour = picture(64, 48, [](int x, int y) {
    return Rgbf(of_byte(x * 3 + y), of_byte(7 * y), of_byte(x * y));
  });
  const Texels texels(*colour);
  expect_equal(texels, *colour);
  EXPECT_LE(texels.bytes(), 64 * 48 * 3 + sizeof(Texels) + 256 * sizeof(float));
}

TEST(Texels, GreyPicturesHaveOneChannel) {
  const auto grey = picture(64, 48, [](int x, int y) { return Rgbf(of_byte(5 * x + y)); });
  const Texels bytes(*grey);
  expect_equal(bytes, *grey);
  EXPECT_LE(bytes.bytes(), 64 * 48 + sizeof(Texels) + 256 * sizeof(float));
  const auto floats =
      picture(64, 48, [](int x, int y) { return Rgbf(std::sqrt(float(x + 64 * y))); });
  const Texels wide(*floats);
  expect_equal(wide, *floats);
  EXPECT_LE(wide.bytes(), 64 * 48 * sizeof(float) + sizeof(Texels));
}

TEST(Texels, OtherPicturesKeepTheirFloats) {
  const auto floats = picture(33, 7, [](int x, int y) {
    return Rgbf(0.1F * static_cast<float>(x), std::exp(0.1F * static_cast<float>(x + y)),
                1e-20F * static_cast<float>(y));
  });
  expect_equal(Texels(*floats), *floats);
  // 257 values in the last texel of all.
  const auto many = picture(257, 1, [](int x, int) { return Rgbf(static_cast<float>(x)); });
  expect_equal(Texels(*many), *many);
}

TEST(Texels, HalvesAreMeansAndTakeLessMemory) {
  const auto colour = picture(8, 6, [](int x, int y) {
    return Rgbf(static_cast<float>(x), static_cast<float>(y), static_cast<float>(x * y));
  });
  Texels texels(*colour);
  const std::size_t before = texels.bytes();
  texels.halve();
  ASSERT_EQ(texels.width(), 4);
  ASSERT_EQ(texels.height(), 3);
  EXPECT_LT(texels.bytes(), before);
  const double step = 24.5 / 65535;  // the mean of the brightest four is 24.5 or more
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) {
      const Rgb c = texels.texel(x, y);
      EXPECT_NEAR(c.r, 2 * x + 0.5, 2 * step);
      EXPECT_NEAR(c.g, 2 * y + 0.5, 2 * step);
      EXPECT_NEAR(c.b, (2 * x + 0.5) * (2 * y + 0.5), 2 * step);
    }
  texels.halve();
  EXPECT_EQ(texels.height(), 2);  // the last row is the mean of one
  EXPECT_NEAR(texels.texel(0, 1).g, 4.5, 4 * step);
  while (texels.width() * texels.height() > 1) texels.halve();
  EXPECT_NEAR(texels.texel(0, 0).r, 3.5, 8 * step);
}

TEST(Texels, BlackPicturesStayBlack) {
  Texels texels(*picture(4, 4, [](int, int) { return Rgbf(0); }));
  texels.halve();
  EXPECT_EQ(texels.texel(1, 1), Rgb(0));
}

}  // namespace
}  // namespace lucerna
