// Unusual and invalid image files.  The test writes files of 32-bit floats (.pfm), OpenImageIO
// writes the others.
#include "server/formats/image_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/server/formats/picture_texts.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::message;
using testing::pfm;
using testing::remarks_of;
using testing::written;

TEST(ImageReader, FloatsAreLinearAndRowsFromTheTop) {
  const auto d = decode_image({"a.pfm", pfm(1, 2, {1, 2, 3, 0.25F, 5e4F, 0})});
  ASSERT_TRUE(d.ok()) << d.status();
  EXPECT_EQ(d->image->width(), 1);
  EXPECT_EQ(d->image->height(), 2);
  EXPECT_EQ(d->image->texel(0, 0), Rgbf(1, 2, 3));
  EXPECT_EQ(d->image->texel(0, 1), Rgbf(0.25F, 5e4F, 0));
  EXPECT_EQ(remarks_of(*d), "");
}

TEST(ImageReader, IntegersAreSrgbCoded) {
  // IEC 61966-2-1: the code 188/255 is 0.5029 of full light, 10/255 is 10/255/12.92.
  const OIIO::ImageSpec eight(1, 1, 3, OIIO::TypeDesc::UINT8);
  const auto d8 =
      decode_image({"a.png", written("a.png", eight, std::vector<std::uint8_t>{188, 10, 255})});
  ASSERT_TRUE(d8.ok()) << d8.status();
  EXPECT_NEAR(d8->image->texel(0, 0).r, 0.5029, 1e-4);
  EXPECT_NEAR(d8->image->texel(0, 0).g, 10 / 255.0 / 12.92, 1e-7);
  EXPECT_EQ(d8->image->texel(0, 0).b, 1);
  const OIIO::ImageSpec sixteen(1, 1, 3, OIIO::TypeDesc::UINT16);
  for (const std::string name : {"a.png", "a.tif"}) {
    const auto d16 = decode_image(
        {name, written(name, sixteen, std::vector<std::uint16_t>{188 * 257, 10 * 257, 0})});
    ASSERT_TRUE(d16.ok()) << d16.status();
    EXPECT_NEAR(d16->image->texel(0, 0).r, 0.5029, 1e-4);
    EXPECT_NEAR(d16->image->texel(0, 0).g, 10 / 255.0 / 12.92, 1e-7);
    EXPECT_EQ(d16->image->texel(0, 0).b, 0);
  }
}

TEST(ImageReader, SixteenBitCodesDoNotDependOnTheSizeOfThePicture) {
  // Large pictures look codes up, small ones compute each.
  std::vector<std::uint16_t> codes(std::size_t{160} * 160);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint16_t>(i * 37);
  const auto grey = [](int width, int height) {
    return OIIO::ImageSpec(width, height, 1, OIIO::TypeDesc::UINT16);
  };
  const auto large = decode_image({"a.png", written("a.png", grey(160, 160), codes)});
  ASSERT_TRUE(large.ok()) << large.status();
  const std::vector<std::uint16_t> row(codes.begin() + 160, codes.begin() + 320);
  const auto small = decode_image({"a.png", written("a.png", grey(160, 1), row)});
  ASSERT_TRUE(small.ok()) << small.status();
  for (int x = 0; x < 160; ++x) {
    EXPECT_EQ(small->image->texel(x, 0), large->image->texel(x, 1)) << x;
    // IEC 61966-2-1
    const double c = row[static_cast<std::size_t>(x)] / 65535.0;
    const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(small->image->texel(x, 0).r, linear, 1e-6) << x;
  }
}

TEST(ImageReader, HalfIsLinear) {
  OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeDesc::HALF);
  const std::vector<std::uint16_t> halves{0x3c00, 0x3800, 0x7bff, 0, 0x0001, 0x4000};
  const auto d = decode_image({"a.exr", written("a.exr", spec, halves, spec.format)});
  ASSERT_TRUE(d.ok()) << d.status();
  EXPECT_EQ(d->image->texel(0, 0), Rgbf(1, 0.5F, 65504));
  EXPECT_EQ(d->image->texel(1, 0), Rgbf(0, 0x1p-24F, 2));
}

TEST(ImageReader, GreyIsGreyInEveryChannel) {
  const OIIO::ImageSpec spec(2, 1, 1, OIIO::TypeDesc::FLOAT);
  const auto d = decode_image({"a.exr", written("a.exr", spec, std::vector<float>{0.5F, 2})});
  ASSERT_TRUE(d.ok()) << d.status();
  EXPECT_EQ(d->image->texel(0, 0), Rgbf(0.5F));
  EXPECT_EQ(d->image->texel(1, 0), Rgbf(2));
  EXPECT_EQ(remarks_of(*d), "");
}

TEST(ImageReader, AlphaIsIgnoredWithARemark) {
  const OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::UINT8);
  const auto d =
      decode_image({"a.png", written("a.png", spec, std::vector<std::uint8_t>{255, 0, 255, 51})});
  ASSERT_TRUE(d.ok()) << d.status();
  EXPECT_EQ(d->image->texel(0, 0), Rgbf(1, 0, 1));  // not 0.2 of it
  EXPECT_EQ(remarks_of(*d), "a.png has an alpha channel -> alpha is ignored\n");
  OIIO::ImageSpec exr(1, 1, 4, OIIO::TypeDesc::FLOAT);
  const auto e = decode_image({"a.exr", written("a.exr", exr, std::vector<float>{3, 2, 1, 0.5F})});
  ASSERT_TRUE(e.ok()) << e.status();
  EXPECT_EQ(e->image->texel(0, 0), Rgbf(3, 2, 1));
}

TEST(ImageReader, OtherChannelsAreIgnoredButRgbIsNeeded) {
  OIIO::ImageSpec spec(1, 1, 5, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"R", "G", "B", "A", "depth"};
  spec.alpha_channel = 3;
  const std::vector<float> values{1, 2, 3, 1, 9};
  const auto d = decode_image({"a.exr", written("a.exr", spec, values)});
  ASSERT_TRUE(d.ok()) << d.status();
  EXPECT_EQ(d->image->texel(0, 0), Rgbf(1, 2, 3));
  EXPECT_THAT(remarks_of(*d), HasSubstr("1 channels besides R, G, B and A"));
  spec.channelnames = {"n.x", "n.y", "n.z", "u", "v"};
  spec.alpha_channel = -1;
  EXPECT_THAT(message(decode_image({"a.exr", written("a.exr", spec, values)}).status()),
              HasSubstr("allowed: R, G and B; X, Y and Z; or one besides"));
}

TEST(ImageReader, OneTexelAndAHundredThousandInARow) {
  const auto one = decode_image({"a.pfm", pfm(1, 1, {1, 2, 3})});
  ASSERT_TRUE(one.ok()) << one.status();
  EXPECT_EQ(one->image->texel(0, 0), Rgbf(1, 2, 3));
  std::vector<float> values(300000, 1);
  values[3 * 99999] = 7;
  const OIIO::ImageSpec spec(100000, 1, 3, OIIO::TypeDesc::FLOAT);
  for (const auto& [name, bytes] : {std::pair{"b.pfm", pfm(100000, 1, values)},
                                    std::pair{"b.exr", written("b.exr", spec, values)}}) {
    const auto row = decode_image({name, bytes});
    ASSERT_TRUE(row.ok()) << row.status();
    EXPECT_EQ(row->image->width(), 100000);
    EXPECT_EQ(row->image->texel(99999, 0), Rgbf(7, 1, 1));
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

TEST(ImageReader, NegativeTexelsCountAsZeroAndAreCounted) {
  const auto d = decode_image({"a.pfm", pfm(3, 1, {-1, 2, -3, 1, 1, 1, 0, -1e-30F, 0})});
  ASSERT_TRUE(d.ok()) << d.status();
  EXPECT_EQ(d->image->texel(0, 0), Rgbf(0, 2, 0));
  EXPECT_EQ(d->image->texel(2, 0), Rgbf());
  EXPECT_EQ(remarks_of(*d), "a.pfm has 2 texels with a value below 0 -> counted as 0\n");
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
