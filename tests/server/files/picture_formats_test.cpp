// TGA, BMP, QOI, PNM and WebP files, and files whose names do not tell their format.  Files are
// written byte by byte from the formats' specifications, and by OpenImageIO.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/files/image_reader.h"
#include "tests/server/files/limited_pool.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using testing::chars;
using ::testing::HasSubstr;
using testing::LimitedPool;
using testing::message;
using testing::remarks_of;
using testing::written;

/// The codes of the colours, row by row from the top: "1 2 3, 4 5 6; ".
std::string codes_of(const std::string& name, const std::string& bytes) {
  const auto d = decode_image({name, bytes}, {.encoding = kLinear});
  if (!d.ok()) return message(d.status());
  std::string text;
  for (int y = 0; y < d->image->height(); ++y, text += "; ")
    for (int x = 0; x < d->image->width(); ++x) {
      const Rgbf c = d->image->texel(x, y);
      text += x == 0 ? "" : ", ";
      for (const float v : {c.r, c.g, c.b}) text += std::to_string(std::lround(v * 255)) + " ";
      text.pop_back();
    }
  return text;
}

/// [TGA2]: `head` has the fields up to the size, `tail` the bits of a texel and the descriptor.
std::string tga(const std::vector<int>& head, int width, int height, const std::vector<int>& tail,
                const std::vector<int>& body) {
  return chars(head) + chars({0, 0, 0, 0, width, 0, height, 0}) + chars(tail) + chars(body);
}
const std::vector<int> kColours{0, 0, 2, 0, 0, 0, 0, 0};

TEST(TgaPicture, RowsColumnsAndChannelsAreInPlace) {
  // Blue, green, red; the first row is the bottom, unless bit 5 is set; bit 4: from the right.
  const std::vector<int> two_rows{3, 2, 1, 6, 5, 4, 9, 8, 7, 12, 11, 10};
  EXPECT_EQ(codes_of("a.tga", tga(kColours, 2, 2, {24, 0}, two_rows)),
            "7 8 9, 10 11 12; 1 2 3, 4 5 6; ");
  EXPECT_EQ(codes_of("a.TGA", tga(kColours, 2, 2, {24, 0x20}, two_rows)),
            "1 2 3, 4 5 6; 7 8 9, 10 11 12; ");
  EXPECT_EQ(codes_of("a.tga", tga(kColours, 2, 2, {24, 0x30}, two_rows)),
            "4 5 6, 1 2 3; 10 11 12, 7 8 9; ");
  EXPECT_EQ(codes_of("a.tga", tga(kColours, 2, 2, {24, 0x10}, two_rows)),
            "10 11 12, 7 8 9; 4 5 6, 1 2 3; ");
  // A name of three bytes before the texels.
  EXPECT_EQ(codes_of("a.tga", tga({3, 0, 2, 0, 0, 0, 0, 0}, 1, 1, {24, 0}, {65, 66, 67, 3, 2, 1})),
            "1 2 3; ");
}

TEST(TgaPicture, RunsMayCrossRows) {
  const std::vector<int> head{0, 0, 10, 0, 0, 0, 0, 0};
  // Three texels, then two single ones; the rest of the file has no meaning.
  EXPECT_EQ(codes_of("a.tga", tga(head, 2, 2, {24, 0x20}, {0x82, 3, 2, 1, 0x00, 6, 5, 4, 99})),
            "1 2 3, 1 2 3; 1 2 3, 4 5 6; ");
  EXPECT_EQ(codes_of("a.tga", tga(head, 1, 2, {24, 0x20}, {0x01, 3, 2, 1, 6, 5, 4})),
            "1 2 3; 4 5 6; ");
}

TEST(TgaPicture, GreyPalettesAndSmallTexels) {
  EXPECT_EQ(codes_of("a.tga", tga({0, 0, 3, 0, 0, 0, 0, 0}, 2, 1, {8, 0}, {7, 9})),
            "7 7 7, 9 9 9; ");
  EXPECT_EQ(codes_of("a.tga", tga({0, 0, 11, 0, 0, 0, 0, 0}, 2, 1, {8, 0}, {0x81, 7})),
            "7 7 7, 7 7 7; ");
  // A palette of two entries from 5 on.  Index 200 is outside of it.
  EXPECT_EQ(codes_of("a.tga",
                     tga({0, 1, 1, 5, 0, 2, 0, 24}, 3, 1, {8, 0}, {3, 2, 1, 6, 5, 4, 5, 6, 200})),
            "1 2 3, 4 5 6, 4 5 6; ");
  // 1 bit, then 5 of red, green and blue: 31 0 16.
  EXPECT_EQ(codes_of("a.tga", tga(kColours, 1, 1, {16, 0}, {0x10, 0x7c})), "255 0 132; ");
}

TEST(TgaPicture, TheFourthByteIsAlphaOnlyIfTheHeaderSaysSo) {
  const std::vector<int> texel{3, 2, 1, 128};
  const auto with = testing::value_of(decode_image({"a.tga", tga(kColours, 1, 1, {32, 8}, texel)}));
  EXPECT_EQ(remarks_of(with), "a.tga has an alpha channel -> alpha is ignored\n");
  const auto alpha =
      testing::value_of(decode_alpha({"a.tga", tga(kColours, 1, 1, {32, 8}, texel)}));
  ASSERT_EQ(alpha.values.size(), 1U);
  EXPECT_NEAR(alpha.values[0], 128 / 255.0, 1e-7);
  const auto without =
      testing::value_of(decode_image({"a.tga", tga(kColours, 1, 1, {32, 0}, texel)}));
  EXPECT_EQ(remarks_of(without), "");
}

TEST(TgaPicture, WrongFilesAreErrorsThatSaySo) {
  EXPECT_THAT(codes_of("a.tga", "short"), HasSubstr("the file ends early"));
  EXPECT_THAT(codes_of("a.tga", tga({0, 0, 32, 0, 0, 0, 0, 0}, 1, 1, {24, 0}, {1, 2, 3})),
              HasSubstr("image type 32"));
  EXPECT_THAT(codes_of("a.tga", tga(kColours, 1, 1, {8, 0}, {1})), HasSubstr("8 bits"));
  EXPECT_THAT(codes_of("a.tga", tga({0, 0, 1, 0, 0, 0, 0, 24}, 1, 1, {8, 0}, {0})),
              HasSubstr("a palette of 0 entries"));
  EXPECT_THAT(codes_of("a.tga", tga({0, 1, 1, 0, 0, 0, 1, 24}, 1, 1, {8, 0}, {0})),
              HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.tga", tga(kColours, 2, 1, {24, 0}, {1, 2, 3, 4, 5})),
              HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.tga", tga({0, 0, 10, 0, 0, 0, 0, 0}, 9, 9, {24, 0}, {0xff, 1, 2})),
              HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.tga", tga(kColours, 0, 1, {24, 0}, {})), HasSubstr("0 x 1 texels"));
}

std::string little(std::uint32_t value, int count = 4) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

/// A BMP file with a header of 40 bytes, or of 12.  `palette` has also the masks.
std::string bmp(int width, int height, int bits, int compression, const std::string& palette,
                const std::string& body, bool is_core = false) {
  const std::string header =
      is_core ? little(12) + little(width, 2) + little(height, 2) + little(1, 2) + little(bits, 2)
              : little(40) + little(width) + little(height) + little(1, 2) + little(bits, 2) +
                    little(compression) + std::string(20, '\0');
  const auto offset = static_cast<std::uint32_t>(14 + header.size() + palette.size());
  return "BM" + std::string(8, '\0') + little(offset) + header + palette + body;
}

TEST(BmpPicture, RowsEndAtFourBytesAndBeginAtTheBottom) {
  const std::string rows = chars({3, 2, 1, 0, 6, 5, 4, 0});
  EXPECT_EQ(codes_of("a.bmp", bmp(1, 2, 24, 0, "", rows)), "4 5 6; 1 2 3; ");
  EXPECT_EQ(codes_of("a.bmp", bmp(1, -2, 24, 0, "", rows)), "1 2 3; 4 5 6; ");
  EXPECT_EQ(codes_of("a.bmp", bmp(1, 2, 24, 0, "", rows, true)), "4 5 6; 1 2 3; ");
  EXPECT_EQ(codes_of("a.bmp", bmp(1, 2, 32, 0, "", rows)), "4 5 6; 1 2 3; ");
}

/// Four colours (1, 2, 3), (4, 5, 6), (7, 8, 9), (10, 11, 12), and black.
std::string palette(std::size_t entries) {
  std::string bytes = chars({3, 2, 1, 0, 6, 5, 4, 0, 9, 8, 7, 0, 12, 11, 10, 0});
  bytes.resize(4 * entries);
  return bytes;
}

TEST(BmpPicture, PalettesAndRuns) {
  EXPECT_EQ(codes_of("a.bmp", bmp(3, 1, 8, 0, palette(256), chars({0, 1, 2, 0}))),
            "1 2 3, 4 5 6, 7 8 9; ");
  EXPECT_EQ(codes_of("a.bmp", bmp(3, 1, 4, 0, palette(16), chars({0x12, 0x30, 0, 0}))),
            "4 5 6, 7 8 9, 10 11 12; ");
  EXPECT_EQ(codes_of("a.bmp", bmp(3, 1, 1, 0, palette(2), chars({0xa0, 0, 0, 0}))),
            "4 5 6, 1 2 3, 4 5 6; ");
  // Two of colour 1; the end of the row; three single texels with a byte of padding; the end.
  EXPECT_EQ(
      codes_of("a.bmp", bmp(3, 2, 8, 1, palette(256), chars({2, 1, 0, 0, 0, 3, 3, 2, 1, 0, 0, 1}))),
      "10 11 12, 7 8 9, 4 5 6; 4 5 6, 4 5 6, 1 2 3; ");
  // One of colour 2, a step of (1, 1), one of colour 3.
  EXPECT_EQ(codes_of("a.bmp", bmp(3, 2, 8, 1, palette(256), chars({1, 2, 0, 2, 1, 1, 1, 3, 0, 1}))),
            "1 2 3, 1 2 3, 10 11 12; 7 8 9, 1 2 3, 1 2 3; ");
  // Half bytes in turns: 1 2 1; then single texels 3 0 1.
  EXPECT_EQ(
      codes_of("a.bmp", bmp(6, 1, 4, 2, palette(16), chars({3, 0x12, 0, 3, 0x30, 0x10, 0, 1}))),
      "4 5 6, 7 8 9, 4 5 6, 10 11 12, 1 2 3, 4 5 6; ");
  // A run beyond the row does not reach the next one.
  EXPECT_EQ(codes_of("a.bmp", bmp(1, 2, 8, 1, palette(256), chars({9, 1, 0, 0, 0, 1}))),
            "1 2 3; 4 5 6; ");
}

TEST(BmpPicture, MasksOfAnyWidth) {
  EXPECT_EQ(codes_of("a.bmp", bmp(1, 1, 16, 0, "", chars({0x10, 0x7c, 0, 0}))), "255 0 132; ");
  // 5, 6 and 5 bits.
  EXPECT_EQ(codes_of("a.bmp", bmp(1, 1, 16, 3, little(0xf800) + little(0x7e0) + little(0x1f),
                                  chars({0xff, 0x07, 0, 0}))),
            "0 255 255; ");
  // Red in the lowest byte, and alpha in the highest.
  const std::string masks = little(0xff) + little(0xff00) + little(0xff0000) + little(0xff000000);
  const std::string rgba = bmp(1, 1, 32, 6, masks, chars({1, 2, 3, 51}));
  EXPECT_EQ(codes_of("a.bmp", rgba), "1 2 3; ");
  const auto alpha = testing::value_of(decode_alpha({"a.bmp", rgba}));
  ASSERT_EQ(alpha.values.size(), 1U);
  EXPECT_NEAR(alpha.values[0], 0.2, 1e-6);
}

TEST(BmpPicture, WrongFilesAreErrorsThatSaySo) {
  EXPECT_THAT(codes_of("a.bmp", "BM"), HasSubstr("a header of 0 bytes"));
  EXPECT_THAT(codes_of("a.bmp", bmp(1, 1, 24, 4, "", "abcd")), HasSubstr("compression 4"));
  EXPECT_THAT(codes_of("a.bmp", bmp(1, 1, 8, 2, palette(256), "abcd")), HasSubstr("8 bits"));
  EXPECT_THAT(codes_of("a.bmp", bmp(0, 1, 24, 0, "", "abcd")), HasSubstr("0 x 1 texels"));
  EXPECT_THAT(codes_of("a.bmp", bmp(1, INT32_MIN, 24, 0, "", "abcd")), HasSubstr("texels of 24"));
  EXPECT_THAT(codes_of("a.bmp", bmp(2, 2, 24, 0, "", "abcdefgh")), HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.bmp", bmp(2, 2, 8, 0, "abc", "abcdefgh")), HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.bmp", bmp(2, 2, 8, 1, palette(256), chars({0, 9, 1}))),
              HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.bmp", bmp(1, 1, 16, 3, little(5) + little(0) + little(0), "abcd")),
              HasSubstr("a mask of 0x5"));
  EXPECT_EQ(decode_image({"a.bmp", bmp(60000, 60000, 8, 1, palette(256), "")}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

std::string qoi(int width, int height, int channels, int space, const std::vector<int>& body) {
  return "qoif" + chars({0, 0, 0, width, 0, 0, 0, height, channels, space}) + chars(body) +
         chars({0, 0, 0, 0, 0, 0, 0, 1});
}

TEST(QoiPicture, AllOperationsAreRead) {
  // RGB; the difference (1, -2, 0); to green -30 (red -8, blue +7); a run of 2; the index of the
  // first texel, (3 * 10 + 5 * 20 + 7 * 30 + 11 * 255) % 64 = 9.
  EXPECT_EQ(codes_of("a.qoi", qoi(6, 1, 3, 0,
                                  {254, 10, 20, 30, 0x40 | 3 << 4 | 0 << 2 | 2, 0x80 | (-10 + 32),
                                   0 << 4 | 15, 0xc0 | 1, 9})),
            "10 20 30, 11 18 30, 249 8 27, 249 8 27, 249 8 27, 10 20 30; ");
  const std::string rgba = qoi(1, 1, 4, 0, {255, 1, 2, 3, 51});
  EXPECT_EQ(codes_of("a.qoi", rgba), "1 2 3; ");
  const auto alpha = testing::value_of(decode_alpha({"a.qoi", rgba}));
  ASSERT_EQ(alpha.values.size(), 1U);
  EXPECT_NEAR(alpha.values[0], 0.2, 1e-6);
}

TEST(QoiPicture, TheHeaderSaysWhetherCodesAreLinear) {
  for (const int space : {0, 1}) {
    const auto d =
        testing::value_of(decode_image({"a.qoi", qoi(1, 1, 3, space, {254, 188, 188, 188})}));
    EXPECT_NEAR(d.image->texel(0, 0).r, space == 0 ? 0.5029 : 188 / 255.0, 1e-4);
  }
}

TEST(QoiPicture, WrongFilesAreErrorsThatSaySo) {
  EXPECT_THAT(codes_of("a.qoi", "qoif"), HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.qoi", qoi(1, 1, 5, 0, {})), HasSubstr("5 channels"));
  EXPECT_THAT(codes_of("a.qoi", "qoif" + chars({0, 0, 0, 9, 0, 0, 0, 9, 3, 0, 254, 1})),
              HasSubstr("ends early"));
  EXPECT_THAT(codes_of("a.qoi", "qoif" + chars({255, 0, 0, 9, 0, 0, 0, 9, 3, 0, 254, 1})),
              HasSubstr("allowed: 3 or 4 channels"));
}

TEST(PictureFormats, FilesOfOtherProgramsAreRead) {
  // OpenImageIO writes TGA with and without runs, BMP, PPM and WebP.
  std::vector<std::uint8_t> codes(5 * 3 * 3);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint8_t>(i / 6 * 40);
  OIIO::ImageSpec spec(5, 3, 3, OIIO::TypeDesc::UINT8);
  const std::string expected = codes_of("a.png", written("a.png", spec, codes));
  for (const std::string name : {"a.tga", "a.bmp", "a.ppm", "a.tif"})
    EXPECT_EQ(codes_of(name, written(name, spec, codes)), expected) << name;
  spec.attribute("compression", "rle");
  EXPECT_EQ(codes_of("a.tga", written("a.tga", spec, codes)), expected);
  spec.attribute("compression", "lossless");
  EXPECT_EQ(codes_of("a.webp", written("a.webp", spec, codes)), expected);
}

TEST(PictureFormats, TheFirstBytesDecideAndNotTheName) {
  const OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::UINT8);
  const std::vector<std::uint8_t> code{9, 8, 7};
  for (const std::string name : {"a.png", "a.bmp", "a.tga", "a.tif", "a.ppm"}) {
    const std::string bytes = written(name, spec, code);
    for (const std::string other : {"b.jpg", "b", "b.exr", "b.hdr"})
      EXPECT_EQ(codes_of(other, bytes), "9 8 7; ") << name << " as " << other;
  }
  EXPECT_THAT(codes_of("a.png", "GIF89a"), HasSubstr("unknown kind of image, allowed: OpenEXR"));
}

TEST(PictureFormats, ATgaFileWithoutAMarkMayHaveAnyName) {
  const std::string colours = tga(kColours, 1, 1, {24, 0x20}, {3, 2, 1});
  for (const std::string name : {"a.png", "a.jpg", "a"})
    EXPECT_EQ(codes_of(name, colours), "1 2 3; ") << name;
  EXPECT_EQ(codes_of("a.png", tga({0, 1, 1, 0, 0, 1, 0, 24}, 1, 1, {8, 0}, {3, 2, 1, 0})),
            "1 2 3; ");
  EXPECT_EQ(codes_of("a.png", tga({0, 0, 11, 0, 0, 0, 0, 0}, 1, 1, {8, 0}, {0, 7})), "7 7 7; ");
  // No picture: an icon, a cursor, and headers of values that TGA does not have.
  for (const std::string& bytes :
       {chars({0, 0, 1, 0, 1, 0, 16, 16, 0, 0, 1, 0, 24, 0, 9, 0, 8, 0}),
        chars({0, 0, 2, 0, 1, 0, 16, 16, 0, 0, 1, 0, 24, 0, 9, 0, 24, 0}), colours.substr(0, 17),
        tga(kColours, 0, 1, {24, 0}, {3, 2, 1}), tga(kColours, 1, 1, {23, 0}, {3, 2, 1}),
        tga(kColours, 1, 1, {24, 0x40}, {3, 2, 1}),
        tga({0, 2, 2, 0, 0, 0, 0, 0}, 1, 1, {24, 0}, {3, 2, 1})})
    EXPECT_THAT(codes_of("a.png", bytes), HasSubstr("unknown kind of image"));
}

TEST(PictureFormats, ASizeIsCheckedBeforeMemoryIsTaken) {
  const std::string webp = "RIFF" + little(40) + "WEBPVP8X" + little(10) + chars({0, 0, 0, 0}) +
                           little(0x3fff, 3) + little(0x3fff, 3) + std::string(20, '\0');
  const std::string large_tga =
      chars(kColours) + chars({0, 0, 0, 0, 255, 255, 255, 255}) + chars({24, 0, 1, 2, 3});
  EXPECT_EQ(decode_image({"a.webp", webp}).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(decode_image({"a.tga", large_tga}).status().code(),
            absl::StatusCode::kResourceExhausted);
  // 1000 x 1000 texels, which the budget does not have.
  LimitedPool pool(1 << 20);
  LoadBudget budget(&pool);
  const std::string thousand = chars({0xe8, 3, 0xe8, 3});
  const std::string tga = chars({0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0}) + thousand + chars({24, 0});
  EXPECT_EQ(decode_image({"a.tga", tga}, {.budget = &budget}).status().code(),
            absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace lucerna
