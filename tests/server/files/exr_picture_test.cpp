// OpenEXR: colour spaces, windows, layers and parts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/files/image_reader.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using testing::decoded_picture;
using testing::expect_near;
using testing::first_texel;
using ::testing::HasSubstr;
using testing::message;
using testing::remarks_of;
using testing::written;

std::string exr(const OIIO::ImageSpec& spec, const std::vector<float>& values) {
  return written("a.exr", spec, values);
}

TEST(ExrPicture, ChromaticitiesAreConverted) {
  OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
  const float rec2020[8]{0.708F, 0.292F, 0.170F, 0.797F, 0.131F, 0.046F, 0.3127F, 0.3290F};
  spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), rec2020);
  const std::string mixed = exr(spec, {0.5F, 0.5F, 0.25F});
  // [BT2087]
  const Rgb expected{(1.6605 - 0.5876) / 2 - 0.0728 / 4, (-0.1246 + 1.1329) / 2 - 0.0083 / 4,
                     (-0.0182 - 0.1006) / 2 + 1.1187 / 4};
  expect_near(first_texel(mixed), expected, 1e-4);
  const auto surface = testing::value_of(decode_surface({"a.exr", mixed}));
  expect_near(surface.image->texel(0, 0), expected, 1e-4);
  // Normals are no colours.
  EXPECT_EQ(first_texel(mixed, kData), Rgbf(0.5F, 0.5F, 0.25F));
}

TEST(ExrPicture, AWhiteOtherThanD65TintsLightAndNotSurfaces) {
  OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
  const float aces[8]{0.7347F, 0.2653F, 0, 1, 0.0001F, -0.0770F, 0.32168F, 0.33767F};
  spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), aces);
  const std::string white = exr(spec, {1, 1, 1});
  const Rgb light(first_texel(white));
  EXPECT_NEAR(luminance(light), 1, 1e-6);
  EXPECT_GT(light.r, 1.03);  // 6000 K
  EXPECT_LT(light.b, 0.97);
  const auto surface = testing::value_of(decode_surface({"a.exr", white}));
  expect_near(surface.image->texel(0, 0), {1, 1, 1}, 1e-6);
}

TEST(ExrPicture, TheLuminanceOfWhiteScalesLuminancesOnly) {
  OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::FLOAT);
  spec.attribute("whiteLuminance", 200.0F);
  const std::string bytes = exr(spec, {1, 0.5F, 0.25F});
  const DecodedImage sky = decoded_picture(bytes, kLuminances);
  EXPECT_EQ(sky.image->texel(0, 0), Rgbf(200, 100, 50));
  EXPECT_THAT(remarks_of(sky), HasSubstr("(1, 1, 1) is 200 cd/m2 -> its texels times this"));
  const DecodedImage slide = decoded_picture(bytes);
  EXPECT_EQ(slide.image->texel(0, 0), Rgbf(1, 0.5F, 0.25F));
  EXPECT_THAT(remarks_of(slide), HasSubstr("a texel of 1 is the light's level"));
  const auto surface = testing::value_of(decode_surface({"a.exr", bytes}));
  EXPECT_EQ(surface.image->texel(0, 0), Rgbf(1, 0.5F, 0.25F));
  EXPECT_TRUE(surface.remarks.empty());
}

TEST(ExrPicture, TheDisplayWindowIsThePicture) {
  OIIO::ImageSpec spec(2, 2, 1, OIIO::TypeDesc::FLOAT);
  spec.x = 2, spec.y = -1;
  spec.full_x = 1, spec.full_y = 0, spec.full_width = 3, spec.full_height = 2;
  // Texels at (2, -1), (3, -1), (2, 0), (3, 0).  The first two are above the display window.
  const DecodedImage d = decoded_picture(exr(spec, {1, 2, 3, 4}));
  ASSERT_EQ(d.image->width(), 3);
  ASSERT_EQ(d.image->height(), 2);
  const float expected[2][3]{{0, 3, 4}, {0, 0, 0}};
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x) EXPECT_EQ(d.image->texel(x, y).r, expected[y][x]) << x << " " << y;
  EXPECT_THAT(remarks_of(d), HasSubstr("the display window is the picture"));
  spec.full_width = 100000, spec.full_height = 100000;
  EXPECT_EQ(decode_image({"a.exr", exr(spec, {1, 2, 3, 4})}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

TEST(ExrPicture, ALayerOfAnotherNameIsRead) {
  OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Combined.A"};
  const std::string one = exr(spec, {1, 2, 3, 0.5F});
  const DecodedImage d = decoded_picture(one);
  EXPECT_EQ(d.image->texel(0, 0), Rgbf(1, 2, 3));
  EXPECT_EQ(remarks_of(d), "a.hdr has an alpha channel -> alpha is ignored\n");
  const auto alpha = testing::value_of(decode_alpha({"a.exr", one}));
  EXPECT_EQ(alpha.values, std::vector<float>{0.5F});
  // Channels without a prefix come first.  Of several layers, the first in the file is used.
  spec.nchannels = 6;
  spec.channelnames = {"R", "G", "B", "a.R", "a.G", "a.B"};
  EXPECT_EQ(first_texel(exr(spec, {1, 2, 3, 4, 5, 6})), Rgbf(1, 2, 3));
  spec.channelnames = {"a.r", "a.g", "a.b", "b.R", "b.G", "b.B"};
  const DecodedImage two = decoded_picture(exr(spec, {1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(two.image->texel(0, 0), Rgbf(1, 2, 3));
  EXPECT_THAT(remarks_of(two), HasSubstr("has 2 layers with colours -> the layer \"a\""));
}

OIIO::ImageSpec channels(const std::vector<std::string>& names) {
  OIIO::ImageSpec spec(1, 1, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT);
  spec.channelnames = names;
  return spec;
}

TEST(ExrPicture, DepthIsNoColour) {
  const std::vector<float> values{1, 2, 3, 4};
  for (const std::vector<std::string>& names : {std::vector<std::string>{"Z"},
                                                {"ViewLayer.Depth.Z"},
                                                {"depth"},
                                                {"A", "Z"},
                                                {"U", "V"},
                                                {"Z", "ZBack"},
                                                {"R", "G"},
                                                {"Y", "RY", "BY"},
                                                {"P.X", "P.Y", "P.Z"}}) {
    const auto d = decode_image({"a.exr", exr(channels(names), values)});
    EXPECT_THAT(message(d.status()),
                HasSubstr("allowed: R, G and B; X, Y and Z; or one besides alpha and depth"))
        << names[0];
  }
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"Y"}, {"Y", "A"}, {"Y", "Z"}, {"Y", "A", "Z"}, {"mask"}}) {
    const DecodedImage d = decoded_picture(exr(channels(names), values));
    EXPECT_EQ(d.image->texel(0, 0), Rgbf(1)) << names.back();
    EXPECT_EQ(remarks_of(d).find("alpha is ignored") != std::string::npos,
              std::ranges::count(names, "A") > 0);
    EXPECT_EQ(remarks_of(d).find("besides R, G, B and A") != std::string::npos,
              std::ranges::count(names, "Z") > 0);
  }
}

TEST(ExrPicture, TheFirstPartWithColoursIsRead) {
  const std::string bytes =
      testing::exr_parts({channels({"Z"}), channels({"R", "G", "B"}), channels({"R", "G", "B"})},
                         {{9}, {1, 2, 3}, {4, 5, 6}});
  const DecodedImage d = decoded_picture(bytes);
  EXPECT_EQ(d.image->texel(0, 0), Rgbf(1, 2, 3));
  EXPECT_EQ(remarks_of(d), "a.hdr has several pictures -> the first one with colours is used\n");
  EXPECT_THAT(message(decode_image({"a.exr", testing::exr_parts({channels({"Z"}), channels({"Z"})},
                                                                {{9}, {8}})})
                          .status()),
              HasSubstr("channels Z, allowed"));
}

TEST(ExrPicture, WordsNameTheChannelsToo) {
  const std::vector<float> values{1, 2, 3, 0.5F};
  for (const std::vector<std::string>& names : {std::vector<std::string>{"red", "green", "blue"},
                                                {"d.Red", "d.Green", "d.Blue", "d.Alpha"},
                                                {"d.red", "d.green", "d.blue", "d.alpha"}}) {
    // OpenImageIO keeps the order of the names in `values`.
    const std::string bytes = exr(channels(names), values);
    EXPECT_EQ(first_texel(bytes), Rgbf(1, 2, 3)) << names[0];
    const auto alpha = testing::value_of(decode_alpha({"a.exr", bytes}));
    EXPECT_EQ(alpha.values.size(), names.size() - 3);
  }
}

TEST(ExrPicture, XyzBecomesRgb) {
  const std::string bytes = exr(channels({"X", "Y", "Z"}), {0.9505F, 1, 1.0891F});
  const DecodedImage d = decoded_picture(bytes);
  expect_near(d.image->texel(0, 0), {1, 1, 1}, 1e-3);
  EXPECT_EQ(remarks_of(d), "a.hdr has the channels X, Y and Z -> taken as CIE XYZ\n");
  // Normals are no colours.
  EXPECT_EQ(first_texel(bytes, kData), Rgbf(0.9505F, 1, 1.0891F));
}

}  // namespace
}  // namespace lucerna
