// Unusual and invalid image files.  The test writes files of 32-bit floats (.pfm), OpenImageIO
// writes the others.
#include "server/files/image_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::message;
using testing::pfm;
using testing::remarks_of;
using testing::written;

TEST(ImageReader, FloatsAreLinearAndRowsFromTheTop) {
  const auto d = testing::value_of(decode_image({"a.pfm", pfm(1, 2, {1, 2, 3, 0.25F, 5e4F, 0})}));
  EXPECT_EQ(d.image->width(), 1);
  EXPECT_EQ(d.image->height(), 2);
  EXPECT_EQ(d.image->texel(0, 0), Rgbf(1, 2, 3));
  EXPECT_EQ(d.image->texel(0, 1), Rgbf(0.25F, 5e4F, 0));
  EXPECT_EQ(remarks_of(d), "");
}

TEST(ImageReader, SixteenBitCodesDoNotDependOnTheSizeOfThePicture) {
  // Large pictures look codes up, small ones compute each.
  std::vector<std::uint16_t> codes(std::size_t{160} * 160);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint16_t>(i * 37);
  const auto grey = [](int width, int height) {
    return OIIO::ImageSpec(width, height, 1, OIIO::TypeDesc::UINT16);
  };
  const auto large =
      testing::value_of(decode_image({"a.png", written("a.png", grey(160, 160), codes)}));
  const std::vector<std::uint16_t> row(codes.begin() + 160, codes.begin() + 320);
  const auto small =
      testing::value_of(decode_image({"a.png", written("a.png", grey(160, 1), row)}));
  for (int x = 0; x < 160; ++x) {
    EXPECT_EQ(small.image->texel(x, 0), large.image->texel(x, 1)) << x;
    // IEC 61966-2-1
    const double c = row[static_cast<std::size_t>(x)] / 65535.0;
    const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(small.image->texel(x, 0).r, linear, 1e-6) << x;
  }
}

TEST(ImageReader, AlphaIsIgnoredWithARemark) {
  const OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::UINT8);
  const auto d = testing::value_of(
      decode_image({"a.png", written("a.png", spec, std::vector<std::uint8_t>{255, 0, 255, 51})}));
  EXPECT_EQ(d.image->texel(0, 0), Rgbf(1, 0, 1));  // not 0.2 of it
  EXPECT_EQ(remarks_of(d), "a.png has an alpha channel -> alpha is ignored\n");
  OIIO::ImageSpec exr(1, 1, 4, OIIO::TypeDesc::FLOAT);
  const auto e = testing::value_of(
      decode_image({"a.exr", written("a.exr", exr, std::vector<float>{3, 2, 1, 0.5F})}));
  EXPECT_EQ(e.image->texel(0, 0), Rgbf(3, 2, 1));
}

TEST(ImageReader, OtherChannelsAreIgnoredButRgbIsNeeded) {
  OIIO::ImageSpec spec(1, 1, 5, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"R", "G", "B", "A", "depth"};
  spec.alpha_channel = 3;
  const std::vector<float> values{1, 2, 3, 1, 9};
  const auto d = testing::value_of(decode_image({"a.exr", written("a.exr", spec, values)}));
  EXPECT_EQ(d.image->texel(0, 0), Rgbf(1, 2, 3));
  EXPECT_THAT(remarks_of(d), HasSubstr("1 channels besides R, G, B and A"));
  spec.channelnames = {"n.x", "n.y", "n.z", "u", "v"};
  spec.alpha_channel = -1;
  EXPECT_THAT(message(decode_image({"a.exr", written("a.exr", spec, values)}).status()),
              HasSubstr("allowed: R, G and B; X, Y and Z; or one besides"));
}

TEST(ImageReader, OneTexelAndAHundredThousandInARow) {
  const auto one = testing::value_of(decode_image({"a.pfm", pfm(1, 1, {1, 2, 3})}));
  EXPECT_EQ(one.image->texel(0, 0), Rgbf(1, 2, 3));
  std::vector<float> values(300000, 1);
  values[3 * 99999] = 7;
  const OIIO::ImageSpec spec(100000, 1, 3, OIIO::TypeDesc::FLOAT);
  for (const auto& [name, bytes] : {std::pair{"b.pfm", pfm(100000, 1, values)},
                                    std::pair{"b.exr", written("b.exr", spec, values)}}) {
    const auto row = testing::value_of(decode_image({name, bytes}));
    EXPECT_EQ(row.image->width(), 100000);
    EXPECT_EQ(row.image->texel(99999, 0), Rgbf(7, 1, 1));
  }
}

TEST(ImageReader, TexelsThatAreNotFiniteAreErrorsWithTheirPosition) {
  for (const float v : {NAN, INFINITY, -INFINITY}) {
    std::vector<float> values(18, 1);
    values[3 * (1 * 3 + 2) + 1] = v;
    const auto status = decode_image({"sky.pfm", pfm(3, 2, values)}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(message(status), HasSubstr("sky.pfm: texel (2, 1)"));
  }
}

TEST(ImageReader, NoTexelsTooManyTexelsOrAnotherFormatAreErrors) {
  EXPECT_FALSE(decode_image({"a.pfm", pfm(0, 0, {})}).ok());
  const auto many =
      decode_image({"a.pfm", pfm(3, 2, std::vector<float>(18))}, {.max_texels = 5}).status();
  EXPECT_EQ(many.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(message(many), HasSubstr("a.pfm: 3 x 2 texels, allowed: 5"));
  // The header announces 4e9 texels: an error before any allocation.
  EXPECT_EQ(decode_image({"a.pfm", "PF\n64000 64000\n-1.0\n"}).status().code(),
            absl::StatusCode::kResourceExhausted);
  for (const std::string name : {"a.exr", "a.hdr", "a.pfm", "a.png", "a.tif", "a.jpg"}) {
    EXPECT_FALSE(decode_image({name, ""}).ok()) << name;
    EXPECT_FALSE(decode_image({name, "no picture"}).ok()) << name;
  }
  EXPECT_FALSE(decode_image({"a.pfm", pfm(3, 2, std::vector<float>(18)).substr(0, 50)}).ok());
  EXPECT_THAT(message(decode_image({"a.txt", "words"}).status()),
              HasSubstr("allowed: OpenEXR, Radiance, PFM"));
}

}  // namespace
}  // namespace lucerna
